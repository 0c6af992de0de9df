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
#include "contacts.h"

/* ---- Painleve's paradox. A contact that slides and whose own coefficient W_N^T P (W_N
 * - mu W_T d) is not above zero pulls itself in: then there is no force, or two (Painleve 1895),
 * unless others that press keep it from that: the problem without its row has no solution then in
 * which it opens. The same of frictional joints (Klein 1909): none is NSDAE_E_PAINLEVE, of two one
 * is taken. Several together can do so as well: where a problem of accelerations is unsolved, the
 * first contact that slides is to blame. */

/* What a coefficient counts as zero up to, relative to W_N^T P W_N: of a problem as it is, and of
 * one near which an integrator failed. */
typedef enum nsdae_painleve_margin {
  NSDAE_PAINLEVE_EXACT,
  NSDAE_PAINLEVE_NEAR
} nsdae_painleve_margin;

/* The status of the problem at t, or NSDAE_E_PAINLEVE with the record. by_rows: it was solved as a
 * complementarity problem. */
int nsdae_painleve_judge(const nsdae_contacts *contacts, int status, int by_rows,
                         nsdae_painleve_margin margin, double t);

/* Whether the j-th slide of the solved problem slides in a known direction and has a second
 * solution: the friction that a unit of its multiplier calls for feeds more than that unit. */
int nsdae_painleve_twofold(const nsdae_contacts *contacts, int j);

/* NSDAE_E_PAINLEVE with the record: the contact's force is without bound at t, where a unit of it
 * gives no more than the coefficient. */
int nsdae_painleve_unbounded(const nsdae_contacts *contacts, int contact, double t,
                             double coefficient);

/* ---- acceleration.c */

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
  double *bound;             /* f: with the friction circles */
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
int nsdae_event_accelerate(nsdae_event_acceleration *acceleration, nsdae_painleve_margin margin);
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

/* ---- projected_gauss_seidel.c: Friction in two directions with the cone itself, from the solution
 * with the polygon around it: projected block Gauss-Seidel (Jean, "The non-smooth contact dynamics
 * method", 1999). With xi = G F + offset, of accelerations or of velocities, in turn for every
 * contact
 *
 *   F_N := max(0, F_N - xi_N / G_NN)
 *   F_T := the point of the disk |F_T| <= mu F_N closest to F_T - xi_T / rho,   rho >= |G_TT|
 *
 * whose fixed points are the solutions: 0 <= F_N _|_ xi_N >= 0, and F_T = -mu F_N xi_T / |xi_T|
 * where xi_T is not zero. A contact that slides already has F_T = -mu F_N d, and moves along
 * W_N - mu W_T d. */

/* Brings the solved problem's impulses to the cone, with the direction [k nt] of what slides, and
 * with them v [nv], lambda [m] and the contacts' velocities after. force, xi [columns] are for its
 * work, and the residual of the problem is that of the cones then, up to contact_tol. 1; 0 where it
 * was not found, or there are slides: then all is as before. */
int nsdae_projected_gauss_seidel(nsdae_contacts *contacts, const double *direction, double *force,
                                 double *xi, double *v, double *lambda);

/* The same from no impulse on, with v and lambda without any: where the problem was not solved, or
 * its contacts are pressed. The modes are then for the cones to say. Where it was not found the
 * problem's impulses are gone. */
int nsdae_projected_gauss_seidel_anew(nsdae_contacts *contacts, const double *direction,
                                      double *force, double *xi, double *v, double *lambda);

/* Whether the solution presses bodies against each other out of all proportion, which a problem
 * near one without a solution allows. */
int nsdae_contacts_pressed(const nsdae_contacts *contacts);

#endif
