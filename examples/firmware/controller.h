/*
 * The Wheelbot's controller: what a main loop calls every 10 ms.
 *
 * wheelbot_tick() is the arithmetic of a tick. Here is what it leaves to the caller: counters of the
 * encoders, and the memory from tick to tick.
 */
#ifndef CONTROLLER_H
#define CONTROLLER_H

#include "wheelbot_tick.h"

#include <stdint.h>

#define CONTROLLER_MEMORY 9

/* An encoder's counts; they may wrap. */
struct counter {
    uint32_t first;
    uint32_t before;
};

struct controller {
    wheelbot_tick_real gains[8];
    wheelbot_tick_real bias[2];
    wheelbot_tick_real memory[CONTROLLER_MEMORY]; /* roll and pitch, rad, in front */
    wheelbot_tick_real felt[2];                   /* the same by the accelerometers alone */
    wheelbot_tick_real currents[2];               /* reaction wheel, rolling wheel, A */
    struct counter reaction;
    struct counter rolling;
};

/* What the sensors show at a tick, in SI units along the IMUs' own axes. */
struct readings {
    wheelbot_tick_real gyroscopes[12];
    wheelbot_tick_real accelerometers[12];
    int32_t reaction; /* counts */
    int32_t rolling;  /* counts */
};

/* The published gains; starts at a roll and pitch, rad, and at what the encoders show. */
void controller_start(
    struct controller *c,
    wheelbot_tick_real roll,
    wheelbot_tick_real pitch,
    int32_t reaction,
    int32_t rolling);

/* One tick; currents and memory are then new. */
void controller_tick(struct controller *c, const struct readings *r);

#endif /* CONTROLLER_H */
