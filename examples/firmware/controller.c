#include "controller.h"

#define GAIN(x) ((wheelbot_tick_real)(x))

/* The difference of two counts that may have wrapped: without sign there is no overflow. */
static wheelbot_tick_real counts(uint32_t later, uint32_t earlier)
{
    const uint32_t forward = later - earlier;
    const uint32_t backward = earlier - later;
    return (forward <= backward) ? (wheelbot_tick_real)forward : -(wheelbot_tick_real)backward;
}

static void count(struct counter *c, int32_t shown, wheelbot_tick_real turned[2])
{
    const uint32_t now = (uint32_t)shown;
    turned[0] = counts(now, c->before);
    turned[1] = counts(now, c->first);
    c->before = now;
}

void controller_start(
    struct controller *c,
    wheelbot_tick_real roll,
    wheelbot_tick_real pitch,
    int32_t reaction,
    int32_t rolling)
{
    /* Those of (6.22): tilt, tilt rate, wheel angle, wheel rate; of roll, then of pitch. */
    static const wheelbot_tick_real published[8] = {
        GAIN(4.5), GAIN(0.25), GAIN(0.0003), GAIN(0.0018),
        GAIN(1.6), GAIN(0.14), GAIN(0.04), GAIN(0.0344)
    };
    int i;
    for (i = 0; i < 8; i++) {
        c->gains[i] = published[i];
    }
    for (i = 0; i < CONTROLLER_MEMORY; i++) {
        c->memory[i] = 0;
    }
    for (i = 0; i < 2; i++) {
        c->bias[i] = 0;
        c->felt[i] = 0;
        c->currents[i] = 0;
    }
    c->memory[0] = roll;
    c->memory[1] = pitch;
    c->reaction.first = (uint32_t)reaction;
    c->reaction.before = c->reaction.first;
    c->rolling.first = (uint32_t)rolling;
    c->rolling.before = c->rolling.first;
}

void controller_tick(struct controller *c, const struct readings *r)
{
    static const wheelbot_tick_real no_torque[2] = { 0 };
    wheelbot_tick_real turned[4];
    count(&c->reaction, r->reaction, &turned[0]);
    count(&c->rolling, r->rolling, &turned[2]);
    wheelbot_tick(
        c->gains, c->bias, turned, r->gyroscopes, r->accelerometers, no_torque, c->memory,
        c->memory, c->felt, c->currents);
}
