/* A steering assist against rolling, as somebody else would write it: plain C behind FMI 2.0
 * co-simulation. It fails on demand, so that masters can be judged by how they take it.
 *
 *   demand  τ_d = −k_φ φ − (k_p + k_p′ V) φ̇ − k_w θ̇, at most ± the motor's limit
 *   motor   T dτ/dt = τ_d − τ, stepped exactly while the inputs are held; T = 0: τ = τ_d at once
 * STATELESS makes a library that cannot save states. */
#define _POSIX_C_SOURCE 199309L /* nanosleep */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef void *Component;
typedef unsigned Reference;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;
typedef struct {
    void (*logger)(void *, const char *, Status, const char *, const char *, ...);
    void (*unused[3])(void);
    void *environment;
} Callbacks;

/* Value references, as in modelDescription.xml; FAULT is the one Integer. */
enum { ROLL, ROLL_RATE, STEER_RATE, SPEED, ASSIST_TORQUE, ROLL_GAIN, ROLL_RATE_GAIN,
       ROLL_RATE_GAIN_SLOPE, STEER_RATE_GAIN, TORQUE_LIMIT, MOTOR_TIME, FAULT_TIME, FAULT, VARIABLES };
/* Values of FAULT; who ends early returns Discard too, but calls it the end. */
enum { NONE, RETURNS_ERROR, RETURNS_DISCARD, RETURNS_FATAL, HANGS, ENDS_EARLY, RETURNS_NAN };
enum { INSTANTIATED, INITIALIZATION, STEP_COMPLETE, STEP_FAILED, TERMINATED };
enum { LAST_SUCCESSFUL_TIME = 2, IS_TERMINATED = 3 }; /* fmi2StatusKind */

typedef struct {
    double value[VARIABLES]; /* the place of ASSIST_TORQUE holds the motor's torque */
    double time;
    int phase;
} State;

typedef struct {
    State state;
    const Callbacks *callbacks;
    char name[64];
} Instance;

static const double ROUNDING = 1e-9; /* times that differ by less are the same [s] */
static const State START = {
    {[SPEED] = 8.0 / 3.6, [ROLL_GAIN] = 10.0, [ROLL_RATE_GAIN] = 40.0, [ROLL_RATE_GAIN_SLOPE] = -5.0,
     [STEER_RATE_GAIN] = 1.0, [TORQUE_LIMIT] = 10.0, [MOTOR_TIME] = 0.02, [FAULT_TIME] = 1.0},
    0.0, INSTANTIATED};

static Status say(const Instance *i, Status status, const char *what, double number)
{
    const char *category = status == FATAL ? "logStatusFatal"
                         : status == ERROR ? "logStatusError" : "logStatusDiscard";
    i->callbacks->logger(i->callbacks->environment, i->name, status, category, "%s %g", what, number);
    return status;
}

/* Comparisons, not fmin and fmax, which would hide a NaN. */
static double demand(const double *v)
{
    double roll_rate_gain = v[ROLL_RATE_GAIN] + v[ROLL_RATE_GAIN_SLOPE] * v[SPEED];
    double torque = -v[ROLL_GAIN] * v[ROLL] - roll_rate_gain * v[ROLL_RATE]
                  - v[STEER_RATE_GAIN] * v[STEER_RATE];
    double limit = v[TORQUE_LIMIT];
    return torque > limit ? limit : torque < -limit ? -limit : torque;
}

static double read(const State *s, Reference variable)
{
    int broken = s->value[FAULT] == RETURNS_NAN && s->time > s->value[FAULT_TIME] + ROUNDING;
    if (variable != ASSIST_TORQUE || (!broken && s->value[MOTOR_TIME] > 0.0))
        return s->value[variable];
    return broken ? NAN : demand(s->value);
}

static void move(State *s, double to)
{
    double *torque = &s->value[ASSIST_TORQUE], motor_time = s->value[MOTOR_TIME];
    if (motor_time > 0.0)
        *torque -= (demand(s->value) - *torque) * expm1((s->time - to) / motor_time);
    s->time = to;
}

Status fmi2DoStep(Component c, double time, double h, int never_back)
{
    (void)never_back;
    State *s = &((Instance *)c)->state;
    double fault_time = s->value[FAULT_TIME];
    if (s->phase != STEP_COMPLETE)
        return say(c, ERROR, "a step is not allowed in phase", s->phase);
    if (!(h > 0.0) || !(fabs(time - s->time) <= ROUNDING))
        return say(c, ERROR, "expected a step forward from where the last one ended, found", time);
    s->time = time;
    int fault = time + h > fault_time + ROUNDING ? (int)s->value[FAULT] : NONE;
    for (int n = 0; fault == HANGS && n < 6000; n++)
        nanosleep(&(struct timespec){0, 10000000}, NULL);
    if (fault == NONE || fault == HANGS || fault == RETURNS_NAN) {
        move(s, time + h);
        return OK;
    }
    s->phase = STEP_FAILED;
    if (fault == RETURNS_ERROR || fault == RETURNS_FATAL)
        return say(c, fault == RETURNS_FATAL ? FATAL : ERROR, "fails as told at", time);
    move(s, fault_time > time ? fault_time : time);
    return say(c, DISCARD, "stops as told at", s->time);
}

Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                          const Callbacks *callbacks, int visible, int logging)
{
    (void)guid, (void)resources, (void)visible, (void)logging;
    Instance *i = type == 1 ? malloc(sizeof *i) : NULL;
    if (!i)
        return NULL;
    *i = (Instance){START, callbacks, ""};
    snprintf(i->name, sizeof i->name, "%s", name);
    return i;
}

void fmi2FreeInstance(Component c) { free(c); }
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
Status fmi2Reset(Component c) { return ((Instance *)c)->state = START, OK; }

static Status enter(Instance *i, int from, int to)
{
    if (i->state.phase != from)
        return say(i, ERROR, "not allowed in phase", i->state.phase);
    i->state.phase = to;
    return OK;
}

Status fmi2SetupExperiment(Component c, int has_tolerance, double tolerance, double time)
{
    (void)has_tolerance, (void)tolerance;
    ((Instance *)c)->state.time = time;
    return enter(c, INSTANTIATED, INSTANTIATED);
}

Status fmi2EnterInitializationMode(Component c) { return enter(c, INSTANTIATED, INITIALIZATION); }
Status fmi2ExitInitializationMode(Component c) { return enter(c, INITIALIZATION, STEP_COMPLETE); }
Status fmi2Terminate(Component c) { return enter(c, ((Instance *)c)->state.phase, TERMINATED); }

#define ACCESS(Name, type, has) \
    Status fmi2Get##Name(Component c, const Reference *r, size_t n, type *v) \
    { \
        const State *s = &((Instance *)c)->state; \
        for (size_t k = 0; k < n; v[k] = (type)read(s, r[k]), k++) \
            if (!(has) || s->phase == INSTANTIATED) \
                return say(c, ERROR, "cannot read " #Name, r[k]); \
        return OK; \
    } \
    Status fmi2Set##Name(Component c, const Reference *r, size_t n, const type *v) \
    { \
        State *s = &((Instance *)c)->state; \
        for (size_t k = 0; k < n; s->value[r[k]] = v[k], k++) \
            if (!(has) || r[k] == ASSIST_TORQUE || s->phase > STEP_COMPLETE) \
                return say(c, ERROR, "cannot set " #Name, r[k]); \
        return OK; \
    }
ACCESS(Real, double, r[k] < FAULT)
ACCESS(Integer, int, r[k] == FAULT)

Status fmi2GetRealStatus(Component c, int kind, double *time)
{
    *time = ((Instance *)c)->state.time;
    return kind == LAST_SUCCESSFUL_TIME ? OK : DISCARD;
}

Status fmi2GetBooleanStatus(Component c, int kind, int *terminated)
{
    const State *s = &((Instance *)c)->state;
    *terminated = s->phase == STEP_FAILED && s->value[FAULT] == ENDS_EARLY;
    return kind == IS_TERMINATED ? OK : DISCARD;
}

/* What must be there and has nothing to offer; it looks at none of its further arguments. */
#define NOTHING(Name, status) Status fmi2##Name(Component c) { return (void)c, status; }

#ifdef STATELESS
NOTHING(GetFMUstate, ERROR) NOTHING(SetFMUstate, ERROR) NOTHING(FreeFMUstate, ERROR)
#else
Status fmi2GetFMUstate(Component c, State **saved)
{
    if (!*saved)
        *saved = malloc(sizeof **saved);
    **saved = ((Instance *)c)->state;
    return OK;
}

Status fmi2SetFMUstate(Component c, const State *saved) { return ((Instance *)c)->state = *saved, OK; }
Status fmi2FreeFMUstate(Component c, State **saved) { return free(*saved), *saved = NULL, (void)c, OK; }
#endif

NOTHING(SetDebugLogging, OK) NOTHING(CancelStep, ERROR)
#define NO(Name) Status fmi2##Name(Component c, void *r, size_t n) { return (void)c, (void)r, n ? ERROR : OK; }
NO(GetBoolean) NO(SetBoolean) NO(GetString) NO(SetString)
NOTHING(SerializedFMUstateSize, ERROR) NOTHING(SerializeFMUstate, ERROR)
NOTHING(DeSerializeFMUstate, ERROR) NOTHING(GetDirectionalDerivative, ERROR)
NOTHING(SetRealInputDerivatives, ERROR) NOTHING(GetRealOutputDerivatives, ERROR)
NOTHING(GetStatus, DISCARD) NOTHING(GetIntegerStatus, DISCARD) NOTHING(GetStringStatus, DISCARD)
