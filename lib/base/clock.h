/* Wall-clock time, for statistics and for when to flush. */
#ifndef NSDAE_BASE_CLOCK_H
#define NSDAE_BASE_CLOCK_H

#include <time.h>

static inline double nsdae_wall_clock(void)
{
  struct timespec now;
  timespec_get(&now, TIME_UTC);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#endif
