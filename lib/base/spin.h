/* Waiting for another thread without sleep, for times below those of a system call. */
#ifndef NSDAE_BASE_SPIN_H
#define NSDAE_BASE_SPIN_H

#include <sched.h>
#include <stdatomic.h>

/* Lets the processor save power or serve its other thread. */
static inline void nsdae_spin_pause(void)
{
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ volatile("yield");
#endif
}

/* One more look in vain: after some 2 us the other thread may wait for this processor. */
static inline void nsdae_spin(int *spins)
{
  enum { MANY = 64 };
  if (++*spins < MANY)
    nsdae_spin_pause();
  else
    sched_yield();
}

#endif
