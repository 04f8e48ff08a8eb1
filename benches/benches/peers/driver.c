/* Times compiled C on request: CasADi's functions and our own, with the loop and the clock
 * that the Rust side has. Reads states, then commands; see peers/driver.rs. */
#define _POSIX_C_SOURCE 199309L
#include "iiwa7.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifdef DYNAMICS_FLOAT
typedef float real;
#else
typedef double real;
#endif

typedef int casadi_function(const real **, real **, long long *, real *, int);
typedef void our_function(const iiwa7_parameters *, const iiwa7_point *, const real *, real *);

#define CASADI(name) casadi_function name;
#include "casadi.inc"
#undef CASADI

/* Ours behind one signature; the results lie in memory as one run of numbers. */
#define PLAIN(name, cast) \
    static void our_##name(const iiwa7_parameters *p, const iiwa7_point *x, const real *a, real *out) \
    { (void)a; iiwa7_##name(p, x, cast out); }
#define STATED(name, cast) \
    static void our_##name(const iiwa7_parameters *p, const iiwa7_point *x, const real *a, real *out) \
    { iiwa7_##name(p, x, a, cast out); }
PLAIN(mass_matrix, (real (*)[7]))
PLAIN(bias_force, )
PLAIN(mass_matrix_and_bias_force, (iiwa7_mass_matrix_and_bias_force_result *)(void *))
PLAIN(forward_dynamics, )
PLAIN(contact, (iiwa7_contact_result *)(void *))
STATED(inverse_dynamics_derivatives, (iiwa7_inverse_dynamics_derivatives_result *)(void *))
PLAIN(forward_dynamics_derivatives, (iiwa7_forward_dynamics_derivatives_result *)(void *))
PLAIN(jacobian, (real (*)[7]))
PLAIN(jacobian_and_rate, (iiwa7_jacobian_and_rate_result *)(void *))

static const struct { const char *name; casadi_function *casadi; our_function *ours; } functions[] = {
#define CASADI(name) { #name, name, 0 },
#include "casadi.inc"
#undef CASADI
#define OURS(name) { #name, 0, our_##name },
    OURS(mass_matrix) OURS(bias_force) OURS(mass_matrix_and_bias_force) OURS(forward_dynamics)
    OURS(contact) OURS(inverse_dynamics_derivatives) OURS(forward_dynamics_derivatives)
    OURS(jacobian) OURS(jacobian_and_rate)
};

enum { STATES = 64, JOINTS = 7 };
static iiwa7_point states[STATES];
static real accelerations[STATES][JOINTS];
static real results[4][128];
static real flat[512];

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

static const real *arguments[STATES][2][3];
static real *places[4] = { results[0], results[1], results[2], results[3] };

/* Evaluates at `count` states in turn, from state `first` on. */
static void run(int f, long first, long count)
{
    long k;
    if (functions[f].casadi) {
        /* The third argument of the derivatives of the inverse dynamics is an acceleration. */
        int stated = strcmp(functions[f].name, "drnea_ana_cse") == 0;
        casadi_function *function = functions[f].casadi;
        for (k = first; k < first + count; k++)
            function(arguments[k % STATES][stated], places, 0, 0, 0);
    } else {
        our_function *function = functions[f].ours;
        for (k = first; k < first + count; k++)
            function(&iiwa7_nominal, &states[k % STATES], accelerations[k % STATES], flat);
    }
}

static int get(real *x)
{
    double v;
    if (scanf("%lf", &v) != 1) return 0;
    *x = (real)v;
    return 1;
}

int main(void)
{
    char command[64];
    char name[64];
    int s, i, f;
    long count;
    for (s = 0; s < STATES; s++) {
        for (i = 0; i < JOINTS; i++) if (!get(&states[s].q[i])) return 1;
        for (i = 0; i < JOINTS; i++) if (!get(&states[s].v[i])) return 1;
        for (i = 0; i < JOINTS; i++) if (!get(&states[s].u[i])) return 1;
        for (i = 0; i < JOINTS; i++) if (!get(&accelerations[s][i])) return 1;
        for (i = 0; i < 2; i++) {
            arguments[s][i][0] = states[s].q;
            arguments[s][i][1] = states[s].v;
            arguments[s][i][2] = i ? accelerations[s] : states[s].u;
        }
    }
    while (scanf("%63s %63s %ld", command, name, &count) == 3) {
        for (f = 0; f < (int)(sizeof functions / sizeof *functions); f++)
            if (strcmp(functions[f].name, name) == 0) break;
        if (f == (int)(sizeof functions / sizeof *functions)) return 2;
        if (strcmp(command, "value") == 0) {
            run(f, count, 1);
            for (i = 0; i < 512; i++)
                printf("%.17g ", (double)(functions[f].casadi ? results[i / 128][i % 128] : flat[i]));
            printf("\n");
        } else {
            double start = now();
            run(f, 0, count);
            printf("%.17g\n", (now() - start) / (double)count);
        }
        fflush(stdout);
    }
    return 0;
}
