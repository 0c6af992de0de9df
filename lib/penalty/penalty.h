/* What the method works with beside the stepper. */
#ifndef NSDAE_PENALTY_H
#define NSDAE_PENALTY_H

#include "dip.h"
#include "equations.h"
#include "smooth.h"

/* The gaps that cross zero in the last step. */
typedef struct nsdae_penalty_gaps {
  nsdae_fall fall; /* of an open contact the gap, of a closed one the overlap */
  nsdae_dip dip;
  double *shift, depth; /* k: where a gap counts as zero; the largest overlap at `ahead` */
  int *found, pending;  /* k: contacts that close or open at `ahead`; any does */
} nsdae_penalty_gaps;

/* Of a contact list, see tracking.h. */
typedef struct nsdae_penalty_slots {
  nsdae_tracking tracking;
  int *keep;   /* k: whose slots are not free */
  int replays; /* steps are those of before */
} nsdae_penalty_slots;

typedef struct nsdae_penalty {
  nsdae_penalty_equations equations;
  nsdae_smooth integrator;
  nsdae_penalty_gaps gaps;
  nsdae_penalty_slots slots;
  nsdae_arena arena;
  double *qv, *z[2];     /* nq + nv: at `ahead`; n: between which the step is accounted for */
  double *peak, *force;  /* k: largest force of each contact until `ahead`; force there */
  double ahead, reached; /* integrated, accounted for up to here */
  double widest;         /* largest sine of the constraints since the step began */
  long stamp, stamps;    /* of the memory that the integrator stands at, 0: none; given so far */
} nsdae_penalty;

static inline const nsdae_dims *nsdae_penalty_dims(const nsdae_penalty *p)
{
  return &p->equations.stepper->system->dims;
}

static inline int nsdae_penalty_is_tracked(const nsdae_penalty *p)
{
  return p->equations.stepper->system->tracked != NULL;
}

/* q and v at t in the last step, into the room of the equations or elsewhere. */
static inline int nsdae_penalty_read(nsdae_penalty *p, double t, double *qv)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  return nsdae_smooth_read(&p->integrator, t, d->nq + d->nv, qv);
}

/* ---- switching.c: NSDAE_OK, or a status with the record */

/* Whether the law has a force for contact i. */
int nsdae_penalty_check_law(const nsdae_stepper *stepper, const char *where, int i);
/* The status and record of an integrator that failed at t, unless there is a record already. */
int nsdae_penalty_failed(nsdae_penalty *penalty, int status, double t);

/* The base to t, where q and v are qv; the integrator from the base on; both, stiff or not. */
int nsdae_penalty_move_base(nsdae_penalty *penalty, double t);
int nsdae_penalty_start_integrator(nsdae_penalty *penalty);
int nsdae_penalty_start(nsdae_penalty *penalty, double t, int stiff);

/* From a state that this method did not lead to; after gaps that crossed zero at t. */
int nsdae_penalty_begin(nsdae_penalty *penalty, const nsdae_terms *from);
int nsdae_penalty_switch_contacts(nsdae_penalty *penalty, nsdae_result *result, double t);

/* ---- slots: nothing is done for fixed contacts */

void nsdae_penalty_slots_layout(nsdae_penalty *penalty, nsdae_arena *arena);

int nsdae_penalty_slots_anew(void *penalty, nsdae_terms *at, double h);
int nsdae_penalty_slots_trim(nsdae_penalty *penalty, const nsdae_terms *from);
int nsdae_penalty_slots_cover(nsdae_penalty *penalty, double from);
int nsdae_penalty_slots_close(nsdae_penalty *penalty, double from);

/* The gaps of a step from `from` to the result's end; the table is that of the memory. */
int nsdae_penalty_slots_show(nsdae_penalty *penalty, nsdae_terms *from, nsdae_result *result);
void nsdae_penalty_slots_keep(const nsdae_penalty *penalty, nsdae_memory *memory);

#endif
