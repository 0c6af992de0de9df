/* Whether an integrator still gets on. Where a callback fails recoverably from some time on, it
 * halves its step for ever: a step below the rounding of t is a success to it. Some such steps are
 * good, its first ones after a restart: it may double its step each time, so that a hundred make
 * 1e30 times the first. */
#ifndef NSDAE_STALLED_STEPS_H
#define NSDAE_STALLED_STEPS_H

#include <nsdae/status.h>

#include "lists.h"

enum { NSDAE_STALLED_MAX = 100 };

typedef struct nsdae_progress {
  int failed;  /* code of a callback that gave up in this step */
  int refused; /* a callback asked for a smaller step in it */
  int stalled; /* steps since t went on */
} nsdae_progress;

/* A status of the library as a callback's code: what a smaller step may help is positive. */
static inline int nsdae_progress_code(int status, const nsdae_error *error)
{
  if (status == NSDAE_OK || status == NSDAE_ARRAYS_GROW) return status;
  if (status == NSDAE_E_CALLBACK) return error->code < 0 ? -1 : 1;
  return status == NSDAE_E_NONFINITE ? -1 : 1;
}

/* The status of an integrator that a code ended: a full list is no failure of a callback. */
static inline int nsdae_progress_status(int code)
{
  return code == NSDAE_ARRAYS_GROW ? NSDAE_ARRAYS_GROW : NSDAE_E_CALLBACK;
}

/* Notes a callback's code and hands it on. */
static inline int nsdae_progress_note(nsdae_progress *progress, int code)
{
  if (code < 0) progress->failed = code;
  if (code > 0) progress->refused = 1;
  return code;
}

static inline void nsdae_progress_begin(nsdae_progress *progress)
{
  progress->failed = progress->refused = 0;
}

/* After a step; returns whether the integrator is to be given up, rather in a step with a reason to
 * tell. */
static inline int nsdae_progress_lost(nsdae_progress *progress, int advanced)
{
  progress->stalled = advanced ? 0 : progress->stalled + 1;
  return progress->stalled > (progress->refused ? 1 : 2) * NSDAE_STALLED_MAX;
}

#endif
