/* CasADi's C of one robot behind the driver. Compiled with -DPOSITIONS=, -DVELOCITIES= and -DFUNCTIONS= a list
 * `FUNCTION(mass) FUNCTION(bias) …` of those that there are. */
#include "driver.h"

/* Numbers per state: q, v, tau, a. */
enum { TOGETHER = POSITIONS + 3 * VELOCITIES, SQUARE = VELOCITIES * VELOCITIES };

static const double *arguments_at[STATES][2][16];
static double results[4][SQUARE];
static double *places[16] = { results[0], results[1], results[2], results[3] };

/* Of each function: whether its third argument is an acceleration, not a force, and the sizes of its results. */
enum { third_mass = 0, third_bias = 0, third_both = 0, third_forward = 0, third_inverse_by = 1, third_forward_by = 0 };
static const int sizes_mass[] = { SQUARE, 0 };
static const int sizes_bias[] = { VELOCITIES, 0 };
static const int sizes_both[] = { SQUARE, VELOCITIES, 0 };
static const int sizes_forward[] = { VELOCITIES, 0 };
static const int sizes_inverse_by[] = { SQUARE, SQUARE, 0 };
static const int sizes_forward_by[] = { VELOCITIES, SQUARE, SQUARE, SQUARE, 0 };

static int put(double *out, const int *sizes)
{
    int written = 0;
    for (int r = 0; sizes[r]; r++) {
        memcpy(out + written, results[r], sizeof(double) * (size_t)sizes[r]);
        written += sizes[r];
    }
    return written;
}

#define FUNCTION(name) \
    int name(const double **, double **, long long *, double *, int); \
    static void run_##name(int s) { name(arguments_at[s][third_##name], places, 0, 0, 0); } \
    static int fetch_##name(double *out) { return put(out, sizes_##name); }
FUNCTIONS
#undef FUNCTION

int main(int count, char **arguments)
{
    static const task tasks[] = {
#define FUNCTION(name) { #name, run_##name, fetch_##name },
        FUNCTIONS
#undef FUNCTION
    };
    if (count != 2) return 2;
    read_states(arguments[1], TOGETHER);
    for (int s = 0; s < STATES; s++)
        for (int third = 0; third < 2; third++) {
            arguments_at[s][third][0] = states[s];
            arguments_at[s][third][1] = states[s] + POSITIONS;
            arguments_at[s][third][2] = states[s] + POSITIONS + VELOCITIES + third * VELOCITIES;
        }
    return serve(tasks, sizeof tasks / sizeof *tasks);
}
