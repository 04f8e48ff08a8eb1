/* The equation of motion at recorded states: how the robot accelerates, and what holds its wheel. */
#include "replay.h"
#include "wheelbot.h"

#include <string.h>

static wheelbot_point point;
static wheelbot_constrained_dynamics_result result;

static void prepare(const struct record *record)
{
    memcpy(point.q, record->q, sizeof point.q);
    memcpy(point.v, record->v, sizeof point.v);
    memcpy(point.u, record->u, sizeof point.u);
}

static void work(void)
{
    wheelbot_constrained_dynamics(&wheelbot_nominal, &point, &result);
}

int main(void)
{
    static const float *const results[] = {
        result.constrained_acceleration, result.constrained_multipliers
    };
    static const int lengths[] = { 7, 2 };
    target_start();
    replay("motion", prepare, work, results, lengths, 2);
    target_stop();
    return 0;
}
