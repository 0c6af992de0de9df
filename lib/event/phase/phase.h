/* The equations between two instants. There the modes of the contacts and frictional joints are
 * fixed and the motion is the index-1 problem in y = [q, v, lambda, F_N, F_T, F_S], linear in v'
 * and the forces: these are solved for at every point, and q' and v' integrated
 *
 *   q' = H v
 *   M v' + Phi_q^T lambda - W_N F_N - W_T F_T - W_S F_S = F
 *   Phi_q v' + omega + 2 alpha Phi' + beta^2 Phi = 0                                       (6)
 *   open:     F_N = 0
 *   closed:   W_N^T v' + omega_N + 2 alpha g' + beta^2 g = 0
 *   sliding:  F_T = -mu F_N d,  d the direction of sliding;    F_S = -mu |lambda| s
 *   sticking: W_T^T v' + omega_T + 2 alpha v_T = 0;            W_S^T v' + omega_S + 2 alpha v_S = 0
 *
 * Where constraints are redundant the columns of Z are an orthonormal base of the range of
 * Phi_q M^-1 Phi_q^T where the phase started, the rows (6) are Z Z^T (...) + (1 - Z Z^T) lambda =
 * 0: the combinations that say nothing give way to the multipliers' least norm. A phase ends where
 * Z has turned too far. In place of (6) one by one, a row that was left out may be the one that
 * says what the others cannot when the mechanism has moved. A contact that depends on others has a
 * relation F_p = sum_l r_l F_l in place of its row, a slide its part of |lambda|: see
 * hyperstatic.h. Forces are numbered p = i for F_N, k + j for F_T.
 *
 * With K = [M Phi_q^T; Phi_q 0] and the columns w of the forces f that are not zero anyway, the
 * motion is K [v'; lambda] = [F + W f; c] with c from (6). This is put into the rows of f, which
 * are few: the border. Its matrix takes one solution K^-1 [w; 0] for each column. */
#ifndef NSDAE_EVENT_PHASE_H
#define NSDAE_EVENT_PHASE_H

#include "change_point.h"
#include "newton_kkt.h"
#include "hyperstatic.h"

/* The state between two events. */
typedef struct nsdae_event_modes {
  int *contact;          /* k: enum nsdae_mode */
  double *direction;     /* k nt: unit vector of sliding, zero where there is none yet; with two
                            directions it follows the velocity from step to step */
  int *frictional_joint; /* f: NSDAE_MODE_OPEN without friction */
  int *slide_sense, *normal_sense; /* f: signs of the sliding velocity and of lambda */
  int *slide_row;                  /* f: a slide that sticks has a row */
  double *slide_part; /* f: F_S = -(b + mu |lambda|) times this where it slides or has no row */
  int *redundant;     /* constraints that depend on others */
  double *basis;      /* of redundant ones: Z, see nsdae_kkt_basis */
  int *related;       /* k (1 + nt), see hyperstatic.h: a relation stands in place of the row */
  double *relation;   /* squared: r of those that are */
  double slow;        /* slower than this a body hardly slides, in this phase */
  double none;        /* accelerations up to this are none, where the modes were chosen */
  double *blur;       /* k: 1, or more: the factor on the tolerances of friction */
  int *integrator;    /* 1: enum nsdae_integrator, which goes through it */
} nsdae_event_modes;

/* The row of a force. */
typedef enum nsdae_event_row_kind {
  NSDAE_ROW_NONE,       /* F = 0 */
  NSDAE_ROW_CLOSED,     /* what it holds has no acceleration */
  NSDAE_ROW_RELATED,    /* others hold it: F = sum r_l F_l */
  NSDAE_ROW_RUBS,       /* F_T = -mu F_N d */
  NSDAE_ROW_SLIDE_RUBS, /* F_S = -(b + mu |lambda|) s */
  NSDAE_ROW_HELD        /* a direction of a change point: see change_point.h */
} nsdae_event_row_kind;

typedef struct nsdae_event_row {
  nsdae_event_row_kind kind;
  int force; /* its number */
  int index; /* among those of its kind: W, w, omega and the gap that it closes, or NULL */
  const nsdae_rows *rows;
  const double *w, *omega, *gap;
} nsdae_event_row;

/* The rows of the forces that are not zero anyway, in the order of their numbers. */
typedef struct nsdae_event_rows {
  int count;
  nsdae_event_row *row; /* count */
  int *place;           /* of every force, or -1 */
  double *f;            /* count: right-hand side, then the forces */
} nsdae_event_rows;

typedef struct nsdae_event_phase {
  nsdae_event_setting *setting;
  nsdae_event_modes modes;
  unsigned terms; /* what the equations of the modes need */
  double *x, *l;  /* nv, m: v', lambda */
  double *circle; /* f: friction of the friction circles */
  nsdae_event_rows rows;
  nsdae_event_crossing crossing;
  nsdae_border border;     /* of the rows, with the setting's kkt */
  nsdae_newton_kkt newton; /* of IDA's steps: see phase.c */
  double *moved;           /* nq + nv */
} nsdae_event_phase;

void nsdae_event_phase_layout(nsdae_event_phase *phase, nsdae_arena *arena);

/* Where hyperstatic.h has the force of a contact. */
static inline int nsdae_event_place_of(const nsdae_dims *d, int force)
{
  int j = force - d->k;
  return j < 0 ? force * (1 + d->nt) : j / d->nt * (1 + d->nt) + 1 + j % d->nt;
}

/* Whether the force has a relation in place of its row; of contact i, F_N. */
static inline int nsdae_event_is_related(const nsdae_event_phase *p, int force)
{
  return p->modes.related[nsdae_event_place_of(&p->setting->system->dims, force)];
}

/* Its r_l of another. */
static inline double nsdae_event_relation(const nsdae_event_phase *p, int force, int l)
{
  const nsdae_dims *d = &p->setting->system->dims;
  return p->modes.relation[nsdae_relation_at(d->nt, nsdae_event_place_of(d, force),
                                             nsdae_event_place_of(d, l))];
}

/* Brings `terms` and the rows to what the modes need. */
void nsdae_event_begin_phase(nsdae_event_phase *phase);

/* The forces of y [n] from its q and v, at time t; v' [nv] is in x then, and the terms are there.
 * NSDAE_E_CONVERGENCE: the equations are singular; NSDAE_E_MASS; or a callback's status. The
 * setting's kkt has the factors of this point then. */
int nsdae_event_forces(nsdae_event_phase *phase, double t, double *y);

/* F(t, y, y') of the phase, Newton's matrix and its solution: the callbacks of ida.h. */
int nsdae_event_residual(double t, const double *y, const double *ydot, double cj, double *r,
                         nsdae_event_phase *phase);
int nsdae_event_newton_setup(double t, const double *y, const double *ydot, double cj,
                             nsdae_event_phase *phase);
int nsdae_event_newton_solve(double cj, double *r, double *x, nsdae_event_phase *phase);

/* With the equations that nsdae_event_forces factored last: the acceleration along the normal of
 * contact i, which has a row, that a unit of F_N makes there with all that else holds. */
double nsdae_event_yield(const nsdae_event_phase *phase, int i);

/* With the same: the force of that number that alone gives its row the acceleration a,
 * a / (w^T K^-1 w); 0 if it has no row, or one that gives way to nothing. */
double nsdae_event_force_that_gives(const nsdae_event_phase *phase, int force, double a);

/* Whether contact i is slower along than ten times the tolerance, at the point in work, which
 * has its tangents. */
int nsdae_event_hardly_slides(const nsdae_event_phase *phase, int i);

/* mu F_N - |F_T| of contact i, with the forces of y. */
double nsdae_event_stick_margin(const nsdae_event_phase *phase, const double *y, int i);

/* ---- Directions of sliding. */

/* direction [nt] := -force / |force|, or 0. */
void nsdae_slip_direction_against(double *direction, int nt, const double *force);

/* ---- Contacts that rattle: whose instants follow each other, each soon after the
 * one before. Past 2000 of them the tolerance of such a contact doubles with every 64th, so that it
 * comes to an end; one that is late begins anew. */

typedef struct nsdae_chattering {
  int *count;   /* k */
  double *last; /* k: time of the last */
} nsdae_chattering;

/* An instant of the contact at t, which counts several times where it is sooner than that after the
 * last. */
void nsdae_chattering_note(const nsdae_chattering *rattle, int contact, double t, double soon,
                           int many);

/* 1, or more: the factor on the tolerances. */
double nsdae_chattering_blur(const nsdae_chattering *rattle, int contact);

/* Past few it doubles with every `each`, twenty times at most. */
double nsdae_chattering_growth(int count, int few, double each);

#endif
