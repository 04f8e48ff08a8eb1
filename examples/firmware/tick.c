/* The controller on recorded sensor values. */
#include "controller.h"
#include "replay.h"

#include <string.h>

static struct controller controller;
static struct readings readings;
static int running;

static void prepare(const struct record *record)
{
    memcpy(readings.gyroscopes, record->gyroscopes, sizeof readings.gyroscopes);
    memcpy(readings.accelerometers, record->accelerometers, sizeof readings.accelerometers);
    readings.reaction = record->reaction;
    readings.rolling = record->rolling;
    if (!running) {
        controller_start(&controller, START_ROLL, START_PITCH, record->reaction, record->rolling);
        running = 1;
    }
}

static void work(void)
{
    controller_tick(&controller, &readings);
}

int main(void)
{
    static const float *const results[] = { controller.memory, controller.felt, controller.currents };
    static const int lengths[] = { CONTROLLER_MEMORY, 2, 2 };
    target_start();
    replay("tick", prepare, work, results, lengths, 3);
    target_stop();
    return 0;
}
