/* A progress bar with the remaining time on stderr, if that is a terminal and the run lasts more
 * than a second. */
#ifndef NSDAE_DRIVER_BAR_H
#define NSDAE_DRIVER_BAR_H

typedef struct bar {
  double started, shown; /* clock [s] */
  double begin;          /* part completed before, by a continued run: 0 .. 1 */
  int terminal;          /* stderr is a terminal and the run is not quiet */
  int visible;
} bar;

void bar_begin(bar *b, int quiet);

/* part: 0 .. 1, including the part before; time: of the run [s]. Redrawn ten times a second. */
void bar_move(bar *b, double part, double time);

/* The same with a text. */
void bar_show(bar *b, double part, const char *what);

/* Erases it, so that a line can be printed. */
void bar_clear(bar *b);

#endif
