#include "bar.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

static double clock_now(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void bar_begin(bar *b, int quiet)
{
  *b = (bar){.terminal = !quiet && isatty(STDERR_FILENO)};
  b->started = b->shown = clock_now();
}

void bar_move(bar *b, double part, double time)
{
  enum { WIDTH = 40 };
  static const char full[] = "########################################";
  if (!b->terminal) return;
  double now = clock_now();
  if (now - b->started < 1 || now - b->shown < 0.1) return;
  int cells = (int)(part * (double)WIDTH);
  fprintf(stderr, "\r[%-*.*s] %3.0f %%  t = %.4g s\033[K", WIDTH, cells, full, 100 * part, time);
  b->visible = 1;
  b->shown = now;
}

void bar_clear(bar *b)
{
  if (b->visible) fprintf(stderr, "\r\033[K");
  b->visible = 0;
}
