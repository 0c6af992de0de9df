/* The problem of accelerations at an instant, for what may stay closed:
 *
 *   0 <= F_N  _|_  g'' = W_N^T a + omega_N >= 0,   friction as in law.h, on sliding velocities
 * where there are any and on their rates where they are zero (Pfeiffer and Glocker, "Multibody
 * Dynamics with Unilateral Contacts", 1996, chapters 5 and 8). Where it has no solution, or two,
 * that is Painleve's paradox. */
#ifndef NSDAE_EVENT_ACCELERATION_H
#define NSDAE_EVENT_ACCELERATION_H

#include "phase.h"
#include "hyperstatic.h"

/* What an instant knows of each contact and frictional joint. */
typedef struct nsdae_event_findings {
  int *closed;                       /* k: until now */
  int *touching, *candidate;         /* k: may be hit; may stay closed */
  int *released, *breakaway;         /* k: pulled; its friction is used up */
  int *stopped, *moving;             /* k: slid until now; slides already, or breaks away */
  int *slide_breakaway;              /* f */
  int *slide_stopped, *slide_turned; /* f: the second: lambda changed its sign */
} nsdae_event_findings;

typedef struct nsdae_event_acceleration {
  nsdae_event_phase *phase;
  nsdae_event_findings is;
  nsdae_contacts problem;
  nsdae_impulses solution;
  nsdae_law *law;            /* k: of the problem */
  double around;             /* of the cone of friction, in parts of that of its polygon */
  int *sense;                /* f: slides with a known direction in it */
  double *a, *lambda, *size; /* nv, m, nv: of the solution; how large the terms of a are */
  double *force, *xi;        /* columns: for cones */
  int by_cones;              /* the solution is theirs */
  nsdae_hyperstatic sharing; /* of its forces */
  double looser;             /* of the sharing */
} nsdae_event_acceleration;

void nsdae_event_acceleration_layout(nsdae_event_acceleration *acceleration, nsdae_arena *arena);
/* Sizes, before the layout; the laws after it, and again after options or coefficients changed. */
void nsdae_event_acceleration_prepare(nsdae_event_acceleration *acceleration);

/* Laws of the candidates, with the velocities of the point, of which those up to size are none;
 * right after an impact nothing is known to have stopped. */
void nsdae_event_set_laws(nsdae_event_acceleration *acceleration, int impacted, double size);
/* Solves; a paradox is NSDAE_E_PAINLEVE with the record. */
int nsdae_event_accelerate(nsdae_event_acceleration *acceleration);
/* The tolerance of an acceleration. */
double nsdae_event_acceleration_size(const nsdae_event_acceleration *acceleration);

/* Whether the present phase is in Painleve's paradox at t, y: NSDAE_OK or NSDAE_E_PAINLEVE with
 * the record. */
int nsdae_event_diagnose(nsdae_event_acceleration *acceleration, double t, const double *y);

/* ---- choice.c: The modes of the next phase, from the problem of accelerations, which is asked
 * again where its answer is not what was assumed. */

/* Modes of all, with accelerations and forces. NSDAE_OK; NSDAE_E_PAINLEVE, NSDAE_E_CONVERGENCE, or
 * of the problem, with the record. */
int nsdae_event_choose_modes(nsdae_event_acceleration *acceleration, int impacted);

#endif
