#include "stepper.h"

#include <math.h>
#include <string.h>

#include "vector.h"

const nsdae_stepping *nsdae_stepping_of(int method)
{
  static const nsdae_stepping *const all[] = {
      [NSDAE_METHOD_IMPLICIT] = &nsdae_stepping_implicit,
      [NSDAE_METHOD_IMPLICIT_PRINTED] = &nsdae_stepping_printed,
      [NSDAE_METHOD_MOREAU] = &nsdae_stepping_moreau,
      [NSDAE_METHOD_PENALTY] = &nsdae_stepping_penalty,
      [NSDAE_METHOD_EVENT] = &nsdae_stepping_event,
  };
  if (method < 0 || method >= (int)(sizeof all / sizeof *all)) return NULL;
  return all[method];
}

static void prepare_terms(nsdae_stepper *s, nsdae_terms *terms)
{
  terms->system = s->system;
  terms->differences = &s->differences;
  terms->error = s->error;
  terms->evals = &s->evals;
}

/* Differences are good to about 1e-10, relative: an iteration does not settle below that. */
static double settled(const nsdae_system *system, double tol)
{
  const nsdae_dims *d = &system->dims;
  int differs = (d->m > 0 && (!system->constraint_jacobian || !system->constraint_bias)) ||
                (d->k > 0 && (!system->gap_normal || !system->contact_bias));
  return differs ? fmax(tol, 1e-9) : tol;
}

void nsdae_stepper_prepare(nsdae_stepper *s)
{
  const nsdae_sim_options *o = s->options;
  s->iteration_tol = settled(s->system, o->iteration_tol);
  s->method = nsdae_stepping_of(o->method);
  s->impacts_max = 64 + 2 * s->system->dims.k;
  s->changes_max = s->impacts_max + 2 * s->system->dims.f;
  s->differences.system = s->system;
  prepare_terms(s, &s->start);
  prepare_terms(s, &s->middle);
  prepare_terms(s, &s->end);
  s->kkt.n = s->system->dims.nv;
  s->kkt.m = s->system->dims.m;
  s->kkt.rank_tol = o->rank_tol;
  s->contacts.system = s->system;
  s->contacts.error = s->error;
  nsdae_lcp_options_default(&s->contacts.lcp_options);
  s->contacts.lcp_options.tol = o->lcp_tol;
  nsdae_contacts_laws(&s->contacts, o->polygon);
  s->newmark = (nsdae_newmark){.system = s->system,
                               .error = s->error,
                               .kkt = &s->kkt,
                               .alpha = o->baumgarte_alpha,
                               .beta = o->baumgarte_beta,
                               .tol = s->iteration_tol,
                               .iteration_max = o->iteration_max,
                               .least_norm = o->redundant == NSDAE_REDUNDANT_LEAST_NORM};
}

void nsdae_stepper_layout(nsdae_stepper *s, nsdae_arena *arena)
{
  const nsdae_dims *dims = &s->system->dims;
  long n = dims->nv;
  nsdae_differences_layout(&s->differences, arena);
  nsdae_terms_layout(&s->start, arena);
  nsdae_terms_layout(&s->middle, arena);
  nsdae_terms_layout(&s->end, arena);
  nsdae_kkt_layout(&s->kkt, arena);
  nsdae_contacts_layout(&s->contacts, arena);
  nsdae_newmark_layout(&s->newmark, arena);
  s->M = NSDAE_ARENA_DOUBLES(arena, n * n);
  s->q = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  s->v = NSDAE_ARENA_DOUBLES(arena, n);
  s->r = NSDAE_ARENA_DOUBLES(arena, n);
  s->last = NSDAE_ARENA_DOUBLES(arena, n);
  s->size = NSDAE_ARENA_DOUBLES(arena, n);
  s->qdot0 = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  s->qdot1 = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  s->impulse = NSDAE_ARENA_DOUBLES(arena, dims->m);
  s->multiplier = NSDAE_ARENA_DOUBLES(arena, dims->m);
  s->impact = nsdae_arena_take(arena, s->impacts_max, sizeof *s->impact);
  s->change = nsdae_arena_take(arena, s->changes_max, sizeof *s->change);
}

int nsdae_stepper_factor(nsdae_stepper *s, nsdae_terms *terms, const double *M)
{
  int least_norm = s->options->redundant == NSDAE_REDUNDANT_LEAST_NORM;
  int status = nsdae_terms_factor(terms, M, &s->kkt, least_norm);
  if (s->kkt.rank < s->rank) s->rank = s->kkt.rank;
  if (s->kkt.rank > s->rank_most) s->rank_most = s->kkt.rank;
  return status;
}

int nsdae_stepper_impact(nsdae_stepper *s, const nsdae_terms *terms, const double *r, double *v)
{
  int n = s->system->dims.nv, m = s->system->dims.m;
  memcpy(v, r, (size_t)n * sizeof *v);
  for (int i = 0; i < m; i++) s->impulse[i] = -terms->phi_t[i];
  nsdae_kkt_solve(&s->kkt, 1, v, n, s->impulse, m);
  if (!nsdae_contacts_any(&s->contacts)) return NSDAE_OK;
  s->problem = &s->contacts;
  memcpy(s->size, r, (size_t)n * sizeof *s->size);
  nsdae_kkt_solve_mass(&s->kkt, s->size);
  int status = nsdae_contacts_solve(&s->contacts, terms, &s->kkt, s->size, v, s->impulse);
  s->lcps++;
  s->lcp_pivots += s->contacts.info.pivots;
  return status;
}

int nsdae_stepper_kinematics(nsdae_stepper *s, double t, const double *q, const double *v,
                             double *qdot)
{
  int code = nsdae_kinematics(s->system, t, q, v, qdot);
  int status = nsdae_system_callback_status(code, "kinematics", t, s->error);
  if (status < 0) return status;
  return nsdae_system_finite(qdot, s->system->dims.nq, 1, "kinematics", t, s->error);
}

void nsdae_stepper_momentum(const double *M, const double *v, double h, const double *F, int nv,
                            double *r)
{
  for (int i = 0; i < nv; i++) r[i] = h * F[i];
  nsdae_add_product(nv, nv, M, v, r);
}
