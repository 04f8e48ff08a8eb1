/* Our generated C of one robot behind the driver. Compiled with -DHEADER='"arm.h"' -DMODEL=arm. */
#include HEADER
#include "driver.h"

#define PASTE(model, name) model##_##name
#define JOIN(model, name) PASTE(model, name)
#define OF(name) JOIN(MODEL, name)

/* How many positions, velocities and inputs there are. */
enum {
    POSITIONS = sizeof(((OF(point) *)0)->q) / sizeof(double),
    VELOCITIES = sizeof(((OF(point) *)0)->v) / sizeof(double),
    INPUTS = sizeof(((OF(point) *)0)->u) / sizeof(double)
};

static OF(point) points[STATES];
static double accelerations[STATES][VELOCITIES];

double mass_matrix[VELOCITIES][VELOCITIES], bias_force[VELOCITIES], acceleration[VELOCITIES];
OF(mass_matrix_and_bias_force_result) both;
OF(inverse_dynamics_derivatives_result) inverse;
OF(forward_dynamics_derivatives_result) forward;

static void run_mass(int s) { OF(mass_matrix)(&OF(nominal), &points[s], mass_matrix); }
static void run_bias(int s) { OF(bias_force)(&OF(nominal), &points[s], bias_force); }
static void run_both(int s) { OF(mass_matrix_and_bias_force)(&OF(nominal), &points[s], &both); }
static void run_forward(int s) { OF(forward_dynamics)(&OF(nominal), &points[s], acceleration); }
static void run_inverse_by(int s)
{
    OF(inverse_dynamics_derivatives)(&OF(nominal), &points[s], accelerations[s], &inverse);
}
static void run_forward_by(int s) { OF(forward_dynamics_derivatives)(&OF(nominal), &points[s], &forward); }

/* Results lie in memory as one run of numbers. */
#define FETCH(name, results) \
    static int name(double *out) { memcpy(out, &results, sizeof results); return sizeof results / sizeof(double); }
FETCH(fetch_mass, mass_matrix)
FETCH(fetch_bias, bias_force)
FETCH(fetch_both, both)
FETCH(fetch_forward, acceleration)
FETCH(fetch_inverse_by, inverse)
FETCH(fetch_forward_by, forward)

int main(int count, char **arguments)
{
    static const task tasks[] = {
        { "mass", run_mass, fetch_mass },
        { "bias", run_bias, fetch_bias },
        { "both", run_both, fetch_both },
        { "forward", run_forward, fetch_forward },
        { "inverse_by", run_inverse_by, fetch_inverse_by },
        { "forward_by", run_forward_by, fetch_forward_by },
    };
    if (count != 2) return 2;
    read_states(arguments[1], POSITIONS + VELOCITIES + INPUTS + VELOCITIES);
    for (int s = 0; s < STATES; s++) {
        const double *row = states[s];
        memcpy(points[s].q, row, sizeof points[s].q);
        memcpy(points[s].v, row += POSITIONS, sizeof points[s].v);
        memcpy(points[s].u, row += VELOCITIES, sizeof points[s].u);
        memcpy(accelerations[s], row += INPUTS, sizeof accelerations[s]);
    }
    return serve(tasks, sizeof tasks / sizeof *tasks);
}
