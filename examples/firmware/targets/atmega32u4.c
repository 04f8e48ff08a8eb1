/* An ATmega32U4 at 16 MHz, on the robot or in simavr. */
#include "target.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#include <stdint.h>

/*
 * Two timers count from the same instant: one every cycle, which wraps after 65536 of them, and one
 * every 64th, which says how often.
 */
void target_start(void)
{
    UCSR1B = _BV(TXEN1);
    UBRR1 = 0;
    TCCR1A = 0;
    TCCR3A = 0;
}

void target_read(void *to, const void *stored, size_t bytes)
{
    memcpy_P(to, stored, bytes);
}

void target_print(const char *text)
{
    while (*text != '\0') {
        while ((UCSR1A & _BV(UDRE1)) == 0) {
        }
        UDR1 = (uint8_t)*text;
        text++;
    }
}

static void nothing(void)
{
}

static __attribute__((noinline)) uint32_t cycles(void (*work)(void))
{
    uint32_t fine;
    uint32_t coarse;
    TCCR1B = 0;
    TCCR3B = 0;
    TCNT1 = 0;
    TCNT3 = 0;
    TCCR3B = _BV(CS31) | _BV(CS30);
    TCCR1B = _BV(CS10);
    work();
    fine = TCNT1;
    coarse = (uint32_t)TCNT3 * 64U;
    /* The wraps that bring the fine count next to the coarse one. */
    return fine + ((coarse + 32768U - fine) & 0xFFFF0000U);
}

unsigned long target_cost(void (*work)(void))
{
    const uint32_t idle = cycles(nothing);
    return cycles(work) - idle;
}

#define PAINT 0xA5U

/* The end of what is static: there the stack may grow to. */
extern uint8_t __heap_start;

unsigned long target_stack(void (*work)(void))
{
    volatile uint8_t *const here = (volatile uint8_t *)SP;
    volatile uint8_t *place;
    for (place = &__heap_start; place <= here; place++) {
        *place = PAINT;
    }
    work();
    for (place = &__heap_start; *place == PAINT; place++) {
    }
    return (unsigned long)(here + 1 - place);
}

/* Asleep for ever, which ends the simulation. */
void target_stop(void)
{
    cli();
    for (;;) {
        sleep_mode();
    }
}
