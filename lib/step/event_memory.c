/* What the event-driven method keeps: its arrays, laws and integrator. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "event.h"

static void count_sizes(nsdae_event_method *e)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  e->n = nsdae_at_slide(d) + d->f;
  e->roots = 2 * d->k + 2 * d->f;
}

static void layout_rows(nsdae_row_set *s, long n, long k, nsdae_arena *arena)
{
  s->taken = NSDAE_ARENA_INTS(arena, n);
  s->dependent = NSDAE_ARENA_INTS(arena, n);
  s->rank_before = NSDAE_ARENA_INTS(arena, n);
  s->seen = NSDAE_ARENA_INTS(arena, n);
  s->normal = NSDAE_ARENA_INTS(arena, n);
  s->unknown = NSDAE_ARENA_INTS(arena, n);
  s->pivot = NSDAE_ARENA_INTS(arena, n);
  s->solved_mode = NSDAE_ARENA_INTS(arena, k);
  s->factor = NSDAE_ARENA_DOUBLES(arena, n * n);
  s->combination = NSDAE_ARENA_DOUBLES(arena, n * n);
  s->relation = NSDAE_ARENA_DOUBLES(arena, n * n);
  s->system = NSDAE_ARENA_DOUBLES(arena, n * n);
  s->force = NSDAE_ARENA_DOUBLES(arena, n);
  s->weight = NSDAE_ARENA_DOUBLES(arena, n);
  s->emphasis = NSDAE_ARENA_DOUBLES(arena, k);
  s->solved = NSDAE_ARENA_DOUBLES(arena, n);
  s->shift = NSDAE_ARENA_DOUBLES(arena, n);
}

static void layout_phase(nsdae_event_method *e, nsdae_arena *arena)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  long k = d->k, kt = k * d->nt, f = d->f;
  e->y = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->yp = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->order = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->other = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->r = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->at = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->K = NSDAE_ARENA_DOUBLES(arena, (long)e->n * e->n);
  e->zero = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->pivot = NSDAE_ARENA_INTS(arena, e->n);
  e->mode = NSDAE_ARENA_INTS(arena, k);
  e->mode_before = NSDAE_ARENA_INTS(arena, k);
  e->slide_mode_before = NSDAE_ARENA_INTS(arena, f);
  e->direction = NSDAE_ARENA_DOUBLES(arena, kt);
  e->slip = NSDAE_ARENA_DOUBLES(arena, kt);
  e->slide_mode = NSDAE_ARENA_INTS(arena, f);
  e->slide_sense = NSDAE_ARENA_INTS(arena, f);
  e->normal_sense = NSDAE_ARENA_INTS(arena, f);
  e->independent = NSDAE_ARENA_INTS(arena, d->m);
  e->relation = NSDAE_ARENA_INTS(arena, k + kt);
  e->slide_row = NSDAE_ARENA_INTS(arena, f);
  e->slide_part = NSDAE_ARENA_DOUBLES(arena, f);
  layout_rows(&e->rows, k + kt + f, k, arena);
  e->root = nsdae_arena_take(arena, e->roots, sizeof *e->root);
  e->found = NSDAE_ARENA_INTS(arena, e->roots);
  e->other_found = NSDAE_ARENA_INTS(arena, e->roots);
}

static void layout_instant(nsdae_event_method *e, nsdae_arena *arena)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  long k = d->k, rows = d->m + k * (1 + d->nt) + d->f;
  nsdae_contacts_layout(&e->modes, arena);
  e->sliding_sense = NSDAE_ARENA_INTS(arena, d->f);
  e->projector.n = d->nv;
  e->projector.m = (int)rows;
  nsdae_kkt_layout(&e->projector, arena);
  e->J = NSDAE_ARENA_DOUBLES(arena, 2 * rows * d->nv);
  e->c = NSDAE_ARENA_DOUBLES(arena, rows);
  e->a = NSDAE_ARENA_DOUBLES(arena, d->nv);
  e->lambda = NSDAE_ARENA_DOUBLES(arena, d->m);
  e->touching = NSDAE_ARENA_INTS(arena, k);
  e->candidate = NSDAE_ARENA_INTS(arena, k);
  e->released = NSDAE_ARENA_INTS(arena, k);
  e->breakaway = NSDAE_ARENA_INTS(arena, k);
  e->moving = NSDAE_ARENA_INTS(arena, k);
  e->slide_breakaway = NSDAE_ARENA_INTS(arena, d->f);
  e->velocity = NSDAE_ARENA_DOUBLES(arena, k);
  e->last = NSDAE_ARENA_DOUBLES(arena, k);
  e->interval = NSDAE_ARENA_DOUBLES(arena, k);
  e->rest = NSDAE_ARENA_DOUBLES(arena, k);
  e->shrunk = NSDAE_ARENA_INTS(arena, k);
  e->settling = NSDAE_ARENA_INTS(arena, k);
}

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_event_method *e = object;
  const nsdae_dims *d = &e->stepper->system->dims;
  layout_phase(e, arena);
  layout_instant(e, arena);
  e->multiplier = NSDAE_ARENA_DOUBLES(arena, d->m);
  e->normal = NSDAE_ARENA_DOUBLES(arena, d->k);
  e->tangential = NSDAE_ARENA_DOUBLES(arena, d->k * d->nt);
  e->friction = NSDAE_ARENA_DOUBLES(arena, d->f);
}

/* Laws of the problem of accelerations. A polygon is put around the friction cone, so that a
 * contact that would leave it does slide. */
static int prepare_modes(nsdae_event_method *e)
{
  const nsdae_stepper *s = e->stepper;
  const nsdae_dims *d = &s->system->dims;
  int edges = s->options->polygon;
  e->resting = calloc((size_t)d->k + 1, sizeof *e->resting);
  e->law = calloc((size_t)d->k + 1, sizeof *e->law);
  if (!e->resting || !e->law) return NSDAE_E_MEMORY;
  e->modes.system = s->system;
  e->modes.error = s->error;
  e->modes.lcp_options = s->contacts.lcp_options;
  e->modes.law = e->law;
  nsdae_contacts_laws(&e->modes, edges);
  for (int i = 0; i < d->k; i++)
    if (e->law[i].kind == NSDAE_POLYGON)
      e->law[i] = nsdae_law_make(d->nt, e->law[i].mu / cos(acos(-1) / edges), edges);
  memcpy(e->resting, e->law, (size_t)d->k * sizeof *e->law);
  e->projector.rank_tol = s->options->rank_tol;
  return NSDAE_OK;
}

int nsdae_event_make(nsdae_event_method *e)
{
  const nsdae_sim_options *o = e->stepper->options;
  const nsdae_dims *d = &e->stepper->system->dims;
  count_sizes(e);
  int status = prepare_modes(e);
  if (status == NSDAE_OK) status = nsdae_arena_build(&e->arena, layout, e);
  if (status < 0) return status;
  e->modes.slide_sense = e->sliding_sense;
  for (int i = 0; i < nsdae_at_lambda(d); i++) e->order[i] = 1;
  const nsdae_dae_problem problem = {.n = e->n,
                                     .roots = e->roots,
                                     .sparse = o->linear_solver == NSDAE_LINEAR_SPARSE,
                                     .order = e->order,
                                     .residual = nsdae_event_residual,
                                     .jacobian = nsdae_event_jacobian,
                                     .root = nsdae_event_root,
                                     .user = e};
  return nsdae_dae_create(&problem, o->rtol, o->atol, o->dt, &e->dae);
}

void nsdae_event_release(nsdae_event_method *e)
{
  nsdae_dae_destroy(&e->dae);
  nsdae_arena_release(&e->arena);
  free(e->resting);
  free(e->law);
}
