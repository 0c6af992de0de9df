/* What the parts of the event-driven method share: the equations of a phase (event_phase.c), the
 * functions whose zeros end it (event_roots.c), what happens at an instant (event_instant.c) and
 * the run from instant to instant (event.c).
 *
 * Between two instants the modes of the contacts and slides are fixed and the motion is the index-1
 * problem in y = [q, v, lambda, F_N, F_T, F_S]
 *
 *   q' = H v
 *   M v' + Phi_q^T lambda - W_N F_N - W_T F_T - W_S F_S = F
 *   Phi_q v' + omega + 2 alpha Phi' + beta^2 Phi = 0                                       (6)
 *   open:     F_N = 0
 *   closed:   W_N^T v' + omega_N + 2 alpha g' + beta^2 g = 0
 *   sliding:  F_T = -mu F_N d,  d the direction of sliding;    F_S = -mu |lambda| s
 *   sticking: W_T^T v' + omega_T + 2 alpha v_T = 0;            W_S^T v' + omega_S + 2 alpha v_S = 0
 *
 * A redundant constraint has lambda_i = 0 in place of its row; what is reported is of least norm.
 * A contact or slide that depends on others has its part of the forces in place of its row: see
 * event_rows.c.
 */
#ifndef NSDAE_EVENT_H
#define NSDAE_EVENT_H

#include "dae.h"
#include "stepper.h"

/* A root function is kept above zero; an instant is where it falls through zero. */
typedef enum nsdae_root_state {
  NSDAE_ROOT_OFF,    /* has nothing to say in this phase */
  NSDAE_ROOT_LIVE,   /* above zero */
  NSDAE_ROOT_RISING, /* zero at `since` with a known rate: divided by t - since it is above */
  NSDAE_ROOT_MASKED  /* zero to rounding: lifted above until it has left zero */
} nsdae_root_state;

typedef struct nsdae_root {
  nsdae_root_state state;
  double since, start, rate; /* of one that is rising: when, from what rounding left, how fast */
  double size;               /* what counts as zero */
} nsdae_root;

/* Rows of the modes' problem by its columns, n of them: see event_rows.c. */
typedef struct nsdae_row_set {
  int columns, taken_count, dependent_count;   /* of contacts; those of slides come after them */
  int *taken, *dependent, *rank_before, *seen; /* n: in turn; rows taken before; put in turn */
  int *normal, *unknown;                       /* n: of the same contact; place in y */
  double *factor, *combination, *relation;     /* n x n, by rows */
  double *force, *weight;                      /* n */
  double *emphasis;                            /* k, by place among the active */
  double *solved;                              /* n: forces of the problem's solution */
  int *solved_mode;                            /* k */
  double *system, *shift;                      /* n x n, n: of fulfil_relations */
  int *pivot;                                  /* n */
} nsdae_row_set;

typedef struct nsdae_event_method {
  nsdae_stepper *stepper;
  const nsdae_state *state; /* of the step in work */
  nsdae_result *result;
  nsdae_dae *dae;
  nsdae_arena arena;
  int n, roots;      /* length of y; number of root functions */
  double *y, *yp;    /* n: at the last instant, then at any point in work */
  double *order;     /* n: 1 differential, 0 algebraic */
  double *other, *r; /* n: a displaced y and its residual */
  double *at;        /* n: y at a point in between */
  double *K, *zero;  /* n x n, n: equations for the forces; no accelerations */
  int *pivot;        /* n */

  /* the phase */
  unsigned terms;          /* what its equations need */
  int *mode, *mode_before; /* k */
  double *direction;       /* k nt: unit vector of sliding, zero where there is none yet; with two
                              directions it follows the velocity from step to step */
  double *slip;            /* k nt: v_T where the residual is differenced */
  int differencing;        /* now */
  double slow;             /* what counts as zero for a velocity of the phase's start */
  int *slide_mode, *slide_mode_before; /* f: NSDAE_MODE_OPEN without friction */
  int *slide_sense, *normal_sense;     /* f: signs of the sliding velocity and of lambda */
  int *independent;                    /* m: 0 where a constraint is redundant */
  nsdae_row_set rows;
  int *relation;      /* k, k nt: -1, or the column whose relation stands in place of the row */
  int *slide_row;     /* f: of a slide that sticks: has a row */
  double *slide_part; /* f: F_S = -mu |lambda| times this where a slide slides or has no row */
  nsdae_root *root;   /* k normal, k tangential, f normal, f tangential */
  int *found, *other_found; /* roots: not zero where one was met; as the integrator says */

  /* an instant */
  nsdae_law *resting;        /* k: laws of contacts that do not slide */
  nsdae_law *law;            /* k: of the problem of accelerations */
  nsdae_contacts modes;      /* that problem */
  nsdae_impulses forces;     /* its results */
  int *warm;                 /* its warm start */
  int *sliding_sense;        /* f: slides with a known direction in it */
  nsdae_kkt projector;       /* of positions and velocities on all that is closed */
  double *J, *c;             /* rows x nv, rows: what is projected on */
  double *a, *lambda;        /* nv, m: accelerations and multipliers */
  int *touching, *candidate; /* k */
  int *released, *breakaway; /* k */
  int *moving;               /* k: slides already, or breaks away */
  int *slide_breakaway;      /* f */
  double *velocity;          /* k: v(-) of the contacts */
  double *last, *interval;   /* k: last impact and the time to it from the one before */
  double *rest;              /* k: what is left of an accumulation */
  int *shrunk;               /* k: how many intervals in turn were shorter than the one before */
  int *settling;             /* k: the accumulation of this contact ends now */

  /* the step */
  long stamp, stamps;    /* of the memory that the integrator stands at, 0: none; given so far */
  int pending;           /* an instant waits at `ahead` */
  double reached, ahead; /* accounted for up to here; integrated up to here */
  double instant;        /* the last one */
  double *multiplier;    /* m: integral over the step */
  double *normal, *tangential, *friction; /* k, k nt, f: impulses of the step */
  double work;
  int changes;      /* instants in this step */
  int idle;         /* of those, without an impact or a change of mode */
  int first_impact; /* number of the first record of the last instant */
  int endless;      /* impacts of one instant that do not end */
  int settled;      /* accumulations closed in this step */
} nsdae_event_method;

/* Offsets in y. */
static inline int nsdae_at_lambda(const nsdae_dims *d)
{
  return d->nq + d->nv;
}

static inline int nsdae_at_normal(const nsdae_dims *d)
{
  return nsdae_at_lambda(d) + d->m;
}

static inline int nsdae_at_tangential(const nsdae_dims *d)
{
  return nsdae_at_normal(d) + d->k;
}

static inline int nsdae_at_slide(const nsdae_dims *d)
{
  return nsdae_at_tangential(d) + d->k * d->nt;
}

/* Memory: all arrays and the integrator, or NSDAE_E_MEMORY, NSDAE_E_UNSUPPORTED; and its release,
 * also of what was made in part. */
int nsdae_event_make(nsdae_event_method *e);
void nsdae_event_release(nsdae_event_method *e);

/* Adds the integrals of the forces and of the friction's power over a piece of one step of the
 * integrator to multiplier, normal, tangential, friction, work. */
int nsdae_event_account(nsdae_event_method *e, double from, double to);

/* The phase: its callbacks for the integrator. */
int nsdae_event_residual(double t, const double *y, const double *yp, double *r, void *user);
int nsdae_event_jacobian(double t, double c, const double *y, const double *yp, const double *r,
                         double *J, void *user);
/* a = v' and the forces of y [n] from its q and v, at time t: the equations are linear in them. The
 * integrator's own are as good as a Newton iteration, and between its steps only as good as its
 * order. The terms e->terms are then there. */
int nsdae_event_forces(nsdae_event_method *e, double t, double *y);
/* Which terms the equations of the modes need. */
void nsdae_event_set_terms(nsdae_event_method *e);
/* Callback's failure as a code of the integrator. */
int nsdae_event_code(const nsdae_stepper *s, int status);

/* Whether contact i, the j-th tangential row, is without a row of its own. */
static inline int nsdae_event_related(const nsdae_event_method *e, int row)
{
  return e->relation[row] >= 0;
}

/* Roots. */
int nsdae_event_root(double t, const double *y, const double *yp, double *g, void *user);
/* The set for the phase that starts now: after the modes, y and the accelerations are known. */
int nsdae_event_set_roots(nsdae_event_method *e, double t);
/* After a step to t: turns the directions of sliding, puts those that left zero into the set; found
 * where one fell below it or asks for an instant. Returns how many, or a status. */
int nsdae_event_watch_roots(nsdae_event_method *e, double t);

/* mu F_N - |F_T| of contact i, with the forces of y. */
double nsdae_event_stick_margin(const nsdae_event_method *e, const double *y, int i);

/* What counts as zero for positions and for velocities: the integrator's accuracy. */
double nsdae_event_position_size(const nsdae_event_method *e, const nsdae_terms *T);
double nsdae_event_velocity_size(const nsdae_event_method *e, const nsdae_terms *T);

/* The instant t at the state y: projection, impacts, new modes; y and yp are then consistent but
 * for what nsdae_dae_start still does. */
int nsdae_event_instant(nsdae_event_method *e, double t);
/* Whether the present phase is in Painleve's paradox: NSDAE_OK or NSDAE_E_PAINLEVE with the record.
 */
int nsdae_event_diagnose(nsdae_event_method *e, double t);

#endif
