#include "replay.h"

#include <string.h>

static struct record record;

static void print_number(unsigned long number)
{
    char text[11];
    size_t at = sizeof text - 1;
    text[at] = '\0';
    do {
        at--;
        text[at] = (char)('0' + (int)(number % 10UL));
        number /= 10UL;
    } while (number > 0UL);
    target_print(&text[at]);
}

/* The bits, since a decimal would cost a printf and lose some of them. */
static void print_bits(float number)
{
    static const char digits[] = "0123456789abcdef";
    uint32_t bits;
    char text[10];
    int i;
    memcpy(&bits, &number, sizeof bits);
    text[0] = ' ';
    for (i = 8; i > 0; i--) {
        text[i] = digits[bits & 15U];
        bits >>= 4;
    }
    text[9] = '\0';
    target_print(text);
}

static void print_line(const char *name, const char *what, unsigned long number)
{
    target_print(name);
    target_print(what);
    print_number(number);
}

void replay(
    const char *name,
    void (*prepare)(const struct record *record),
    void (*work)(void),
    const float *const results[],
    const int lengths[],
    int count)
{
    int tick;
    for (tick = 0; tick < TICKS; tick++) {
        unsigned long cost;
        int i;
        int k;
        target_read(&record, &records[tick], sizeof record);
        prepare(&record);
        cost = target_cost(work);
        print_line(name, " cost ", cost);
        for (i = 0; i < count; i++) {
            for (k = 0; k < lengths[i]; k++) {
                print_bits(results[i][k]);
            }
        }
        target_print("\n");
    }
    print_line(name, " stack ", target_stack(work));
    target_print("\n");
}
