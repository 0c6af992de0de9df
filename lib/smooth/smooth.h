/* The integrator of a smooth phase: an explicit pair (runge_kutta.h), which starts anew at no cost,
 * and for stiff equations IDA (ida.h).
 *
 *   z = [q, v, integrals of the forces a, further integrals],   z' = f(t, q, v)      (explicit)
 *   y = [q, v, a],   F(t, y, y') = 0                                                 (implicit)
 *
 * The forces a follow from q and v: f gives them as rates of their integrals, which makes y and y'
 * at a start consistent. With IDA the integrals are those of its polynomial of degree 5 at most, by
 * Gauss's quadrature with three points, which is exact for that degree; they are no part of
 * Newton's system.
 *
 * A callback's code NSDAE_ARRAYS_GROW (nsdae_progress_code) ends a start, a step or a reading with
 * that status: a list is full. */
#ifndef NSDAE_SMOOTH_H
#define NSDAE_SMOOTH_H

#include <nsdae/sim.h>

#include "dip.h"
#include "ida.h"
#include "runge_kutta.h"

typedef struct nsdae_smooth {
  nsdae_runge_kutta steps; /* of z: n to user are set before the layout, tolerances before a start;
                              rate is f */
  nsdae_ida_problem implicit; /* residual to user are set before the layout */
  /* rates of the further integrals at y, y', with the forces of y; 0, > 0, < 0 as f */
  int (*powers)(double t, const double *y, const double *ydot, double *rate, void *user);
  nsdae_ida *ida;    /* NULL: not made */
  int is_stiff;      /* IDA is at work */
  double first;      /* length of IDA's first step, or 0; set before a start */
  double *sum[2];    /* integrals: at the start and at the end of the last step */
  double *power;     /* 3 x further: their rates at the nodes of the last step */
  double *y, *ydot;  /* room */
  double from, to;   /* the last step */
  const char *cause; /* of the last failure of IDA, as SUNDIALS names it; or "" */
} nsdae_smooth;

/* Takes the arrays; makes IDA for an option `integrator`: NSDAE_OK, NSDAE_E_MEMORY, or
 * NSDAE_E_UNSUPPORTED if that is ida and the library was built without SUNDIALS. */
void nsdae_smooth_layout(nsdae_smooth *smooth, nsdae_arena *arena);
int nsdae_smooth_make(nsdae_smooth *smooth, int integrator);

/* The integrator from the next start on: an option `integrator` but auto. */
static inline void nsdae_smooth_set(nsdae_smooth *smooth, int integrator)
{
  smooth->is_stiff = integrator == NSDAE_INTEGRATOR_IDA;
  smooth->steps.pair = integrator == NSDAE_INTEGRATOR_DOP853 ? &nsdae_dop853 : &nsdae_dopri5;
}

/* In how many pieces dip.h searches a step: a polynomial of DOP853 has two extrema more than one of
 * DOPRI5 or a smooth one of IDA, for which the two halves do. */
static inline int nsdae_smooth_pieces(const nsdae_smooth *smooth)
{
  return !smooth->is_stiff && smooth->steps.pair == &nsdae_dop853 ? NSDAE_DIP_PIECES : 2;
}

/* Starts (anew) at t from q and v; the integrals are zero there. NSDAE_OK; NSDAE_E_CALLBACK if f
 * fails. */
int nsdae_smooth_start(nsdae_smooth *smooth, double t, const double *qv);

/* One step of its own choice: [from, to]. NSDAE_OK, NSDAE_E_CALLBACK, NSDAE_E_CONVERGENCE. */
int nsdae_smooth_advance(nsdae_smooth *smooth);

/* The first `count` of z at t within the last step. NSDAE_OK, NSDAE_E_CALLBACK,
 * NSDAE_E_CONVERGENCE. */
int nsdae_smooth_read(nsdae_smooth *smooth, double t, int count, double *z);

/* The explicit steps have for long been held back by stability, and IDA is there. */
static inline int nsdae_smooth_stiff(const nsdae_smooth *smooth)
{
  return smooth->ida && !smooth->is_stiff && nsdae_runge_kutta_stiff(&smooth->steps);
}

#endif
