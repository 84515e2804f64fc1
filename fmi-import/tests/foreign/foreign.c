/* A mass on a spring behind FMI 2.0 co-simulation, as somebody else would write it: the tests'
 * stand-in for an FMU of another maker. It moves exactly, refuses when told to, and writes down
 * what is done to it. BARE leaves out what an FMU without capabilities may lack. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef void *Component;
typedef unsigned int Reference;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;
typedef void (*Logger)(void *, const char *, Status, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, Status);
    void *environment;
} Callbacks;

enum { MASS, STIFFNESS, FORCE, POSITION, VELOCITY, POSITION_START, ACCELERATION, REALS };
enum { STEPS, REFUSE, INTEGERS };
enum { HELD, SETTLED, BOOLEANS };
enum { LABEL, TRACE, RESOURCES, STRINGS };
enum { NOTHING, BY_DISCARD, BY_ERROR, BY_FATAL, LATER, LATER_BY_ERROR };

typedef struct {
    double real[REALS];
    int integer[INTEGERS];
    int boolean[BOOLEANS];
    double time, slope;
} State;

typedef struct {
    State state;
    char *string[STRINGS];
    const Callbacks *callbacks;
    char *name;
    int logging, polls, dead;
} Instance;

/* Globals on purpose: what is told at unloading must outlive all instances. */
static char trace[4096], resources[4096];

static void write_down(const char *what)
{
    FILE *file = trace[0] ? fopen(trace, "a") : NULL;
    if (file) {
        fprintf(file, "%s\n", what);
        fclose(file);
    }
}

__attribute__((destructor)) static void unload(void)
{
    /* without file:// */
    write_down(strlen(resources) > 7 && access(resources + 7, F_OK) == 0 ? "unload with resources"
                                                                         : "unload without resources");
}

static char *copy(Instance *i, const char *text)
{
    char *own = i->callbacks->allocate(strlen(text) + 1, 1);
    return own ? strcpy(own, text) : NULL;
}

static void set_string(Instance *i, int which, const char *text)
{
    if (i->string[which])
        i->callbacks->release(i->string[which]);
    i->string[which] = copy(i, text);
    if (which == TRACE)
        snprintf(trace, sizeof trace, "%s", text);
}

#define SAY(i, status, category, ...) \
    if ((i)->logging) \
    (i)->callbacks->logger((i)->callbacks->environment, (i)->name, status, category, __VA_ARGS__)

static void start(Instance *i)
{
    State fresh = {{2.0, 8.0, 0.0, 1.0, 0.0, 1.0, 0.0}, {0, 0}, {0, 0}, 0.0, 0.0};
    i->state = fresh;
    set_string(i, LABEL, "mass");
}

const char *fmi2GetVersion(void)
{
#ifdef VERSION
    return VERSION;
#else
    return "2.0";
#endif
}

Component fmi2Instantiate(const char *name, int type, const char *guid, const char *location,
                          const Callbacks *callbacks, int visible, int logging)
{
    (void)visible;
    if (type != 1 || strcmp(guid, "{f0e1}") != 0) {
        callbacks->logger(callbacks->environment, name, ERROR, "logStatusError",
                          "expected guid %s, found %s", "{f0e1}", guid);
        return NULL;
    }
    Instance *i = callbacks->allocate(1, sizeof *i);
    i->callbacks = callbacks;
    i->logging = logging;
    i->name = copy(i, name);
    set_string(i, RESOURCES, location);
    snprintf(resources, sizeof resources, "%s", location);
    start(i);
    return i;
}

void fmi2FreeInstance(Component c)
{
    Instance *i = c;
    write_down(i->dead ? "free instance after fatal" : "free instance");
    for (int n = 0; n < STRINGS; n++)
        if (i->string[n])
            i->callbacks->release(i->string[n]);
    i->callbacks->release(i->name);
    i->callbacks->release(i);
}

Status fmi2SetupExperiment(Component c, int has_tolerance, double tolerance, double time,
                           int has_stop, double stop)
{
    Instance *i = c;
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    i->state.time = time;
    return OK;
}

Status fmi2EnterInitializationMode(Component c)
{
    Instance *i = c;
    SAY(i, OK, NULL, "100%% ready: %s %d %g", i->string[LABEL], 42, 0.5);
    SAY(i, WARNING, "logStatusWarning", NULL);
    SAY(i, OK, "logAll", "plain");
    return WARNING;
}

static void accelerate(State *s)
{
    s->real[ACCELERATION] = (s->real[FORCE] - s->real[STIFFNESS] * s->real[POSITION]) / s->real[MASS];
}

Status fmi2ExitInitializationMode(Component c)
{
    State *s = &((Instance *)c)->state;
    s->real[POSITION] = s->real[POSITION_START];
    accelerate(s);
    return OK;
}

Status fmi2Terminate(Component c)
{
    (void)c;
    write_down("terminate");
    return OK;
}

Status fmi2Reset(Component c)
{
    start(c);
    return OK;
}

#define ACCESS(Name, type, field, count) \
    Status fmi2Get##Name(Component c, const Reference *r, size_t n, type *v) \
    { \
        for (size_t k = 0; k < n; k++) { \
            if (r[k] >= count) { \
                SAY((Instance *)c, ERROR, "logStatusError", "no " #Name " %u", r[k]); \
                return ERROR; \
            } \
            v[k] = ((Instance *)c)->state.field[r[k]]; \
        } \
        return OK; \
    } \
    Status fmi2Set##Name(Component c, const Reference *r, size_t n, const type *v) \
    { \
        for (size_t k = 0; k < n; k++) { \
            if (r[k] >= count) \
                return ERROR; \
            ((Instance *)c)->state.field[r[k]] = v[k]; \
        } \
        return OK; \
    }

ACCESS(Real, double, real, REALS)
ACCESS(Integer, int, integer, INTEGERS)
ACCESS(Boolean, int, boolean, BOOLEANS)

Status fmi2GetString(Component c, const Reference *r, size_t n, const char **v)
{
    for (size_t k = 0; k < n; k++)
        v[k] = ((Instance *)c)->string[r[k]];
    return OK;
}

Status fmi2SetString(Component c, const Reference *r, size_t n, const char *const *v)
{
    for (size_t k = 0; k < n; k++)
        set_string(c, (int)r[k], v[k]);
    return OK;
}

/* Exact for a force that changes by `slope` per second. */
static void move(State *s, double h)
{
    double k = s->real[STIFFNESS], w = sqrt(k / s->real[MASS]);
    double a = s->real[POSITION] - s->real[FORCE] / k;
    double b = (s->real[VELOCITY] - s->slope / k) / w;
    if (!s->boolean[HELD]) {
        s->real[POSITION] = (s->real[FORCE] + s->slope * h) / k + a * cos(w * h) + b * sin(w * h);
        s->real[VELOCITY] = s->slope / k - a * w * sin(w * h) + b * w * cos(w * h);
    }
    s->real[FORCE] += s->slope * h;
    s->slope = 0.0;
    s->time += h;
    accelerate(s);
}

Status fmi2DoStep(Component c, double time, double h, int never_back)
{
    Instance *i = c;
    State *s = &i->state;
    s->integer[STEPS]++;
    s->boolean[SETTLED] = never_back;
    switch (s->integer[REFUSE]) {
    case BY_DISCARD:
        move(s, h / 2);
        SAY(i, DISCARD, "logStatusDiscard", "step %d of %s to %g s: #r3# is %.3f", s->integer[STEPS],
            i->string[LABEL], time + h, s->real[POSITION]);
        return DISCARD;
    case BY_ERROR:
        SAY(i, ERROR, "logStatusError", "%s refuses at %g s", i->string[LABEL], time);
        return ERROR;
    case BY_FATAL:
        SAY(i, FATAL, "logStatusFatal", "%s is broken", i->string[LABEL]);
        i->dead = 1;
        return FATAL;
    case LATER:
    case LATER_BY_ERROR:
        i->polls = 3;
        move(s, h);
        return PENDING;
    default:
        move(s, h);
        return OK;
    }
}

#ifndef BARE
const char *fmi2GetTypesPlatform(void)
{
#ifdef TYPES
    return TYPES;
#else
    return "default";
#endif
}

Status fmi2SetDebugLogging(Component c, int on, size_t n, const char *const *categories)
{
    Instance *i = c;
    for (size_t k = 0; k < n; k++)
        if (strncmp(categories[k], "log", 3) != 0) {
            SAY(i, ERROR, "logStatusError", "no category %s", categories[k]);
            return ERROR;
        }
    i->logging = on;
    return OK;
}

Status fmi2GetStatus(Component c, int kind, Status *status)
{
    Instance *i = c;
    (void)kind;
    *status = OK;
    if (i->polls > 0) {
        i->polls--;
        *status = PENDING;
    } else if (i->state.integer[REFUSE] == LATER_BY_ERROR) {
        SAY(i, ERROR, "logStatusError", "in vain");
        *status = ERROR;
    }
    return OK;
}

Status fmi2GetRealStatus(Component c, int kind, double *time)
{
    *time = ((Instance *)c)->state.time;
    return kind == 2 ? OK : DISCARD;
}

Status fmi2GetBooleanStatus(Component c, int kind, int *terminated)
{
    (void)c;
    *terminated = 1;
    return kind == 3 ? OK : DISCARD;
}

Status fmi2GetFMUstate(Component c, void **saved)
{
    if (!*saved)
        *saved = malloc(sizeof(State));
    memcpy(*saved, &((Instance *)c)->state, sizeof(State));
    return OK;
}

Status fmi2SetFMUstate(Component c, void *saved)
{
    memcpy(&((Instance *)c)->state, saved, sizeof(State));
    return OK;
}

Status fmi2FreeFMUstate(Component c, void **saved)
{
    (void)c;
    write_down("free state");
    free(*saved);
    *saved = NULL;
    return OK;
}

Status fmi2GetDirectionalDerivative(Component c, const Reference *unknown, size_t unknowns,
                                    const Reference *known, size_t knowns, const double *seed,
                                    double *sensitivity)
{
    const State *s = &((Instance *)c)->state;
    for (size_t u = 0; u < unknowns; u++) {
        sensitivity[u] = 0.0;
        for (size_t k = 0; k < knowns; k++)
            if (unknown[u] == ACCELERATION && known[k] == FORCE)
                sensitivity[u] += seed[k] / s->real[MASS];
    }
    return OK;
}

Status fmi2SetRealInputDerivatives(Component c, const Reference *r, size_t n, const int *order,
                                   const double *v)
{
    for (size_t k = 0; k < n; k++) {
        if (r[k] != FORCE || order[k] != 1)
            return ERROR;
        ((Instance *)c)->state.slope = v[k];
    }
    return OK;
}

Status fmi2GetRealOutputDerivatives(Component c, const Reference *r, size_t n, const int *order,
                                    double *v)
{
    const State *s = &((Instance *)c)->state;
    for (size_t k = 0; k < n; k++) {
        if (order[k] != 1)
            return ERROR;
        v[k] = s->real[r[k] == POSITION ? VELOCITY : ACCELERATION];
    }
    return OK;
}
#endif

#if !defined BARE && !defined NO_BYTES
Status fmi2SerializedFMUstateSize(Component c, void *saved, size_t *size)
{
    (void)c, (void)saved;
#ifdef HUGE_STATE
    *size = (size_t)-1 / 4;
#else
    *size = sizeof(State);
#endif
    return OK;
}

Status fmi2SerializeFMUstate(Component c, void *saved, char *bytes, size_t size)
{
    (void)c;
    memcpy(bytes, saved, size);
    return OK;
}

Status fmi2DeSerializeFMUstate(Component c, const char *bytes, size_t size, void **saved)
{
    if (size != sizeof(State)) {
        SAY((Instance *)c, ERROR, "logStatusError", "expected %d bytes, found %d", (int)sizeof(State),
            (int)size);
        return ERROR;
    }
    *saved = malloc(size);
    memcpy(*saved, bytes, size);
    return OK;
}
#endif
