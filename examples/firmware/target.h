/* What the programs need of the machine that they run on; targets/ has one file for each. */
#ifndef TARGET_H
#define TARGET_H

#include <stddef.h>

/* Tables that stay in flash, where a machine would copy them to RAM otherwise. */
#ifdef __AVR__
#include <avr/pgmspace.h>
#define STORED PROGMEM
#else
#define STORED
#endif

/* Clocks, floating point unit, output. */
void target_start(void);

/* Copies from a table that is STORED. */
void target_read(void *to, const void *stored, size_t bytes);

void target_print(const char *text);

/* What one call costs: instructions on a Cortex-M4F, cycles on an AVR, 0 on a host. */
unsigned long target_cost(void (*work)(void));

/* Bytes of stack that one call takes; 0 on a host. */
unsigned long target_stack(void (*work)(void));

/* Ends the emulation. */
void target_stop(void);

#endif /* TARGET_H */
