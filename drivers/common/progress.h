/* A progress bar with the time left on stderr, where that is a terminal and what goes on lasts
 * over a second. */
#ifndef NSDAE_DRIVER_BAR_H
#define NSDAE_DRIVER_BAR_H

typedef struct bar {
  double started, shown; /* clock [s] */
  double begin;          /* the part that was done before, as by a run that goes on: 0 .. 1 */
  int terminal;          /* stderr is one, and nobody asked for quiet */
  int visible;
} bar;

void bar_begin(bar *b, int quiet);

/* part: 0 .. 1, what was done before included; time: of the run [s]. Redrawn ten times a second. */
void bar_move(bar *b, double part, double time);

/* The same, with what else there is to say. */
void bar_show(bar *b, double part, const char *what);

/* Takes it off the terminal, so that a line can be printed. */
void bar_clear(bar *b);

#endif
