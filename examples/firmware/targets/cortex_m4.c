/*
 * A Cortex-M4F as qemu emulates it (mps2-an386). On your board the vendor's start-up code is in the
 * place of this file, with the cycle counter of its debug unit in target_cost().
 */
#include "target.h"

#include <stdint.h>
#include <string.h>

/* By the linker script. */
extern uint32_t data_stored[], data_first[], data_last[], bss_first[], bss_last[];
extern uint32_t stack_lowest[], stack_top[];

int main(void);
void reset(void);

static void stop(uint32_t reason);

static void fault(void)
{
    target_print("fault\n");
    stop(0x20023U);
}

typedef void (*handler)(void);
static const struct {
    uint32_t *stack;
    handler handlers[15];
} vectors __attribute__((section(".vectors"), used)) = {
    stack_top,
    { reset, fault, fault, fault, fault, fault, 0, 0, 0, 0, fault, fault, 0, fault, fault }
};

#define CPACR (*(volatile uint32_t *)0xE000ED88U)
#define SYST_CSR (*(volatile uint32_t *)0xE000E010U)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014U)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018U)

void reset(void)
{
    const uint32_t *from = data_stored;
    uint32_t *to;
    CPACR |= 0xFU << 20; /* the floating point unit */
    __asm__ volatile("dsb\n\tisb");
    for (to = data_first; to < data_last; to++) {
        *to = *from;
        from++;
    }
    for (to = bss_first; to < bss_last; to++) {
        *to = 0U;
    }
    (void)main();
    target_stop();
}

static void semihost(uint32_t operation, uintptr_t argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register uintptr_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

static void stop(uint32_t reason)
{
    for (;;) {
        semihost(0x18U, reason);
    }
}

void target_start(void)
{
    SYST_RVR = 0xFFFFFFU;
    SYST_CSR = 5U; /* on, by the processor's clock, without interrupt */
}

void target_read(void *to, const void *stored, size_t bytes)
{
    memcpy(to, stored, bytes);
}

void target_print(const char *text)
{
    semihost(0x04U, (uintptr_t)text);
}

static void nothing(void)
{
}

static uint32_t ticks(void (*work)(void))
{
    uint32_t before;
    SYST_CVR = 0U;
    before = SYST_CVR;
    work();
    return (before - SYST_CVR) & 0xFFFFFFU;
}

/*
 * qemu counts instructions (-icount shift=10): one takes 1024 ns, in which the timer of 25 MHz counts
 * 25.6 down.
 */
unsigned long target_cost(void (*work)(void))
{
    const uint32_t idle = ticks(nothing);
    const uint32_t busy = ticks(work);
    return ((unsigned long)(busy - idle) * 5UL + 64UL) / 128UL;
}

#define PAINT 0xA5A5A5A5U

unsigned long target_stack(void (*work)(void))
{
    uint32_t *here;
    uint32_t *place;
    __asm__ volatile("mov %0, sp" : "=r"(here));
    for (place = stack_lowest; place < here; place++) {
        *(volatile uint32_t *)place = PAINT;
    }
    work();
    for (place = stack_lowest; *(volatile uint32_t *)place == PAINT; place++) {
    }
    return (unsigned long)((uintptr_t)here - (uintptr_t)place);
}

void target_stop(void)
{
    stop(0x20026U);
}
