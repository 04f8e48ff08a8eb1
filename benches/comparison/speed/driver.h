/* What every library's program does alike: it reads states from a file, then commands from its input.
 *
 *     value FUNCTION STATE    prints all results at a state
 *     time FUNCTION COUNT     prints nanoseconds per evaluation, over so many evaluations at the states in turn
 *
 * A program states its functions in `tasks` and begins with `read_states`.
 */
#ifndef DRIVER_H
#define DRIVER_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { STATES = 64, LARGEST = 1 << 13 };

typedef struct task {
    const char *name;
    /* Computes at a state; results stay where the library puts them. */
    void (*run)(int state);
    /* Writes what was computed last as plain numbers; how many. */
    int (*fetch)(double *out);
} task;

/* Rows of the file, as many numbers each. */
static double *states[STATES];

/* Reads 64 rows of `width` numbers. */
static void read_states(const char *path, int width)
{
    FILE *file = fopen(path, "r");
    if (!file) { perror(path); exit(2); }
    for (int s = 0; s < STATES; s++) {
        states[s] = (double *)malloc(sizeof(double) * (size_t)width);
        for (int i = 0; i < width; i++)
            if (!states[s] || fscanf(file, "%lf", &states[s][i]) != 1) {
                fprintf(stderr, "%s: row %d has no number %d\n", path, s, i);
                exit(2);
            }
    }
    fclose(file);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

static void answer_value(const task *asked, int state)
{
    static double numbers[LARGEST];
    asked->run(state);
    int count = asked->fetch(numbers);
    for (int i = 0; i < count; i++) printf("%.17g ", numbers[i]);
    printf("\n");
}

static void answer_time(const task *asked, long count)
{
    void (*run)(int) = asked->run;
    double start = now();
    for (long k = 0; k < count; k++) run((int)(k % STATES));
    printf("%.17g\n", (now() - start) / (double)count);
}

/* Answers commands until there are no more. */
static int serve(const task *tasks, int count)
{
    char command[16], name[64];
    long number;
    while (scanf("%15s %63s %ld", command, name, &number) == 3) {
        const task *asked = 0;
        for (int f = 0; f < count; f++)
            if (strcmp(tasks[f].name, name) == 0) asked = &tasks[f];
        if (!asked) { fprintf(stderr, "there is no function %s\n", name); return 2; }
        if (strcmp(command, "value") == 0) answer_value(asked, (int)number);
        else answer_time(asked, number);
        fflush(stdout);
    }
    return 0;
}

#endif
