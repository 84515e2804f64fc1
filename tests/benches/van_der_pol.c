/* Van der Pol's oscillator behind two functions of FMI 2.0, by hand: what the example of fmi-export
 * is compared with. The same equations, the same method, the same internal steps. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

enum { OK = 0, ERROR = 3 };

typedef struct {
    double mu, x[2], der[2], time;
} Instance;

static void derivative(const Instance *m, const double x[2], double der[2]) {
    der[0] = x[1];
    der[1] = m->mu * (1.0 - x[0] * x[0]) * x[1] - x[0];
}

static void rk4(Instance *m, double h) {
    double k1[2], k2[2], k3[2], k4[2], x[2];
    derivative(m, m->x, k1);
    for (int i = 0; i < 2; i++) x[i] = m->x[i] + 0.5 * h * k1[i];
    derivative(m, x, k2);
    for (int i = 0; i < 2; i++) x[i] = m->x[i] + 0.5 * h * k2[i];
    derivative(m, x, k3);
    for (int i = 0; i < 2; i++) x[i] = m->x[i] + h * k3[i];
    derivative(m, x, k4);
    for (int i = 0; i < 2; i++)
        m->x[i] += h * ((k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0);
}

void *fmi2Instantiate(void) {
    Instance *m = calloc(1, sizeof *m);
    if (!m) return NULL;
    m->mu = 1.0;
    m->x[0] = 2.0;
    derivative(m, m->x, m->der);
    return m;
}

void fmi2FreeInstance(void *c) { free(c); }

int fmi2DoStep(void *c, double point, double h, int no_set_state_prior) {
    Instance *m = c;
    (void)no_set_state_prior;
    if (!m || !(h > 0.0) || !isfinite(h) || fabs(point - m->time) > 1e-9) return ERROR;
    double steps = ceil(h / 0.01);
    if (steps > 1e8) return ERROR;
    for (long n = 0; n < (long)steps; n++) rk4(m, h / steps);
    derivative(m, m->x, m->der);
    m->time = point + h;
    return OK;
}

int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value) {
    const Instance *m = c;
    if (!m || (n > 0 && (!vr || !value))) return ERROR;
    for (size_t i = 0; i < n; i++) {
        switch (vr[i]) {
        case 0: value[i] = m->mu; break;
        case 1: value[i] = m->x[0]; break;
        case 2: value[i] = m->x[1]; break;
        case 3: value[i] = m->der[0]; break;
        case 4: value[i] = m->der[1]; break;
        case 5: value[i] = m->time; break;
        default: return ERROR;
        }
    }
    return OK;
}
