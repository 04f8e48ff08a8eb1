/* Runs work over the recorded sensor values, and prints what it computes and costs. */
#ifndef REPLAY_H
#define REPLAY_H

#include "recorded.h"

/* Prepares a record, then computes; called with the machine's stack empty but for main's. */
void replay(
    const char *name,
    void (*prepare)(const struct record *record),
    void (*work)(void),
    const float *const results[],
    const int lengths[],
    int count);

#endif /* REPLAY_H */
