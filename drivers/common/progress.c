#include "progress.h"

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

/* Remaining time "1:02:03" or "2:03", in proportion to the elapsed time. */
static void print_left(double passed, double done, double part)
{
  double left = done > 0 ? passed * (1 - part) / done : 0;
  if (done <= 0 || left >= 360000) return; /* 100 hours: nobody knows */
  int seconds = (int)(left + 0.5), hours = seconds / 3600;
  if (hours > 0) fprintf(stderr, ", %d:%02d:%02d left", hours, seconds / 60 % 60, seconds % 60);
  if (hours == 0) fprintf(stderr, ", %d:%02d left", seconds / 60, seconds % 60);
}

void bar_move(bar *b, double part, double time)
{
  char what[48];
  snprintf(what, sizeof what, "t = %.4g s", time);
  bar_show(b, part, what);
}

void bar_show(bar *b, double part, const char *what)
{
  enum { WIDTH = 40 };
  static const char full[] = "########################################";
  if (!b->terminal) return;
  double now = clock_now();
  if (now - b->started < 1 || now - b->shown < 0.1) return;
  int cells = (int)(part * (double)WIDTH);
  fprintf(stderr, "\r[%-*.*s] %3.0f %%  %s", WIDTH, cells, full, 100 * part, what);
  print_left(now - b->started, part - b->begin, part);
  fprintf(stderr, "\033[K");
  b->visible = 1;
  b->shown = now;
}

void bar_clear(bar *b)
{
  if (b->visible) fprintf(stderr, "\r\033[K");
  b->visible = 0;
}
