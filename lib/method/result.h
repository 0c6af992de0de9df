/* What a step did: all that its method says, and all that records, certificates, impacts and
 * counters are made of. */
#ifndef NSDAE_RESULT_H
#define NSDAE_RESULT_H

#include "contacts.h"
#include "cone_island.h"
#include "single.h"
#include "state.h"

/* Of one step. */
typedef struct nsdae_counters {
  long lcps, lcp_pivots, iterations;
  long events, accumulations; /* instants; accumulations closed */
  long fallbacks;             /* 1: by implicit in place of the method */
  long inexact;               /* 1: a contact problem was left above its tolerance */
  long moved;                 /* 1: projection = slop moved contacts */
  long frozen;                /* 1: contacts of the last iterates of implicit were frozen */
  long accumulations_early;   /* of those: as slow as the integrator's errors */
  double rank_retained,
      rank_discarded;           /* smallest sine that counts in the rank, largest that does not */
  int rank, rank_most;          /* smallest and largest rank of Phi_q; m, 0 where there was none */
  int islands, island_contacts; /* how many; contacts of the largest */
  nsdae_evals evals;
} nsdae_counters;

/* The largest |dPhi/dt| at a point where the method takes Phi_q, if that is not the end of its
 * step. */
typedef struct nsdae_rate {
  int known, constraint;
  double most;
} nsdae_rate;

/* A slide whose friction had two solutions, and the multiplier that was taken; slide -1: none. */
typedef struct nsdae_twofold {
  int frictional_joint;
  double t, lambda;
} nsdae_twofold;

/* A velocity of contact that was closed without its e_N because of the speeds of other bodies
 * alone; velocity 0: none. The contact as texts call it, and its index; tol is the tolerance of all
 * velocities, by the coordinate `fastest`; an rtol below `least` resolves it. */
typedef struct nsdae_unresolved {
  int contact, fastest;
  char called[NSDAE_CALLED_SIZE];
  double t, velocity, tol, least;
} nsdae_unresolved;

/* The first change point that the step crossed: a pose in which this constraint depends on the
 * others. constraint -1: none. sine: the smallest one of a time-stepping step near one; 0: far. */
typedef struct nsdae_crossed {
  int constraint;
  double t, sine;
} nsdae_crossed;

/* The deepest contact of a list that the step did not close and that overlaps at its end. */
typedef struct nsdae_entered {
  double depth; /* 0: none */
  double rate;  /* v_N */
  long id;
  int block[2];
} nsdae_entered;

typedef struct nsdae_result {
  nsdae_terms end;         /* t, q, v where the step ended; a step that located its impacts may
                              end before the time asked for */
  double *multiplier;      /* m: mean bilateral force */
  nsdae_impulses impulses; /* by contact and frictional joint */
  nsdae_closed closed;     /* who they are, by list */
  nsdae_entered entered;   /* who is to be closed by the next step */
  double carried;          /* of contacts by list: sum of Lambda w, the work of moving surfaces;
                              less that of position motors along xi_T */
  int given_up;            /* not a step of this method's: implicit is to do it instead */
  int located;             /* the lists below are the method's; else impacts are found from the
                              impulses, and happen at the end */
  nsdae_impact *impact;    /* impacts_max */
  int impacts, impacts_max;
  nsdae_change *change; /* changes_max: changes of mode */
  int changes, changes_max;
  double work;           /* of contact and friction impulses on the system */
  double lifted;         /* part of work: what a projection of the coordinates alone gave */
  double raised;         /* part of that: potential energy, by projection = slop */
  double gain, turnover; /* of event and penalty: what T = v^T M v / 2 gained by the equations
                            of motion and by impacts, NAN where backward differences of
                            event do not control it; of event its amounts */
  nsdae_rate rate;
  double worst_residual; /* of its contact problems */
  double contact_tol;    /* the largest tolerance of them; 0: there was none */
  struct {
    double residual, tol;
    double hidden;             /* above it too, but below the rounding of heavy loads; or 0 */
  } above;                     /* of the one that is furthest above its tolerance */
  nsdae_twofold twofold;       /* the first of the step */
  nsdae_unresolved unresolved; /* the first of the step */
  nsdae_crossed crossed;
  int smooth;                     /* nothing was closed */
  const nsdae_contacts *problem;  /* the one that was asked last, for who wants to see it fail */
  const nsdae_single *single;     /* the same of one contact in closed form */
  const nsdae_cone_island *cones; /* of the largest island with cones; NULL: none */
  nsdae_counters counters;
  nsdae_memory memory; /* for the next step */
} nsdae_result;

/* Counts a factorisation that found this rank, with the gap in it: kept, left as in kkt.h. */
void nsdae_count_rank(nsdae_counters *counters, int rank, double kept, double left);

/* Takes the arrays; system, differences and error of end and the sizes of memory are set before. */
void nsdae_result_layout(nsdae_result *result, nsdae_arena *arena);

/* Whether contact i was closed or did something in the step. */
int nsdae_result_takes_part(const nsdae_result *result, int i);

/* Whether the lists hold what one more instant may add: an impact of each contact beside those that
 * are kept apart, and a change. */
int nsdae_result_room(const nsdae_result *result);

/* Impacts and changes are kept in the user's time. The id is that of a fixed contact, its number.
 */

/* A new impact of the contact, in order of time; or, after a number of them only one for each
 * contact and the next instant is left, that of the same contact and time. */
nsdae_impact *nsdae_result_impact(nsdae_result *result, double t, int contact, double before);

/* Of a contact or a slide, -1: of none; where there is one. */
void nsdae_result_change(nsdae_result *result, double t, int contact, int frictional_joint,
                         int before, int after);

/* Room in the lists, without those of its terms; NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_result_grow(nsdae_result *result, const nsdae_room *contacts);
void nsdae_result_release(nsdae_result *result);

/* Measures the rate at the terms' point, of the velocity v. */
void nsdae_result_rate(nsdae_result *result, const nsdae_terms *terms, const double *v);

/* A step that did nothing yet; end and memory are not touched. */
void nsdae_result_clear(nsdae_result *result);
/* The same; impulses_follow: those are cleared by who writes them. */
void nsdae_result_begin(nsdae_result *result, int impulses_follow);

#endif
