#include "event_context.h"

#include <math.h>

/* A redundant constraint is one to the integrator's error in positions alone, which must not make
 * it independent: of a sine, in rtol, and at least. */
static const double SINE_ERROR = 100, LEAST_SINE = 1e-6;

/* Of a coordinate: the rounding of a gap. */
static const double ROUNDING = 4e-15;

void nsdae_event_set_places(nsdae_event_setting *s)
{
  const nsdae_dims *d = &s->system->dims;
  s->at.v = d->nq;
  s->at.lambda = s->at.v + d->nv;
  s->at.normal = s->at.lambda + d->m;
  s->at.tangential = s->at.normal + d->k;
  s->at.frictional_joint = s->at.tangential + d->k * d->nt;
  s->at.n = s->at.frictional_joint + d->f;
  s->at.whole = s->at.n + 2 + 3 * d->k;
}

void nsdae_event_move(nsdae_event_setting *s, double t, const double *y)
{
  nsdae_terms_at(s->here, t, y, y + s->at.v);
}

int nsdae_event_factor(nsdae_event_setting *s)
{
  int least_norm = s->options->redundant == NSDAE_REDUNDANT_LEAST_NORM;
  double least = fmax(LEAST_SINE, SINE_ERROR * s->options->rtol);
  s->kkt->rank_tol = least_norm ? fmax(s->options->rank_tol, least) : s->options->rank_tol;
  int status = nsdae_terms_factor(s->here, s->here->M, s->kkt, least_norm);
  nsdae_count_rank(&s->result->counters, s->kkt->rank, s->kkt->kept, s->kkt->left);
  return status;
}

void nsdae_event_add_residual(nsdae_event_setting *s, const nsdae_contacts *c)
{
  nsdae_result *r = s->result;
  r->worst_residual = fmax(r->worst_residual, c->lcp.info.residual);
  r->contact_tol = fmax(r->contact_tol, c->lcp.options.tol);
}

int nsdae_event_solve(nsdae_event_setting *s, nsdae_contacts *c, const nsdae_terms *terms,
                      double *size, double *v, double *lambda)
{
  if (!nsdae_contacts_any(c)) return NSDAE_OK;
  nsdae_result *r = s->result;
  r->problem = c;
  int status = nsdae_contacts_solve(c, terms, s->kkt, size, v, lambda);
  r->counters.lcps++;
  r->counters.lcp_pivots += c->lcp.info.pivots;
  if (status == NSDAE_OK) nsdae_event_add_residual(s, c);
  return status;
}

double nsdae_event_position_size(const nsdae_event_setting *s)
{
  double far = nsdae_largest(s->system->dims.nq, s->here->q);
  double way = s->options->dt * nsdae_largest(s->system->dims.nv, s->here->v);
  const double dt = s->options->dt, *error = s->error_by_differences;
  double drift =
      fmin((error[0] + error[1] * dt / 2) * dt, NSDAE_EVENT_DIFFERENCES * fmin(far, way));
  return 10 * (s->options->rtol * fmin(far, way) + s->options->atol + drift) +
         nsdae_event_rounding(s);
}

double nsdae_event_rounding(const nsdae_event_setting *s)
{
  return ROUNDING * nsdae_largest(s->system->dims.nq, s->here->q);
}

double nsdae_event_velocity_size(const nsdae_event_setting *s)
{
  return nsdae_event_velocity_size_of(s, nsdae_largest(s->system->dims.nv, s->here->v));
}

double nsdae_event_velocity_size_of(const nsdae_event_setting *s, double most)
{
  const double *error = s->error_by_differences;
  double drift = fmin(error[0] + error[1] * s->options->dt, NSDAE_EVENT_DIFFERENCES * most);
  return fmax(s->options->impact_velocity,
              10 * (s->options->rtol * most + s->options->atol + drift));
}

double nsdae_event_own_speed(const nsdae_event_setting *s, int i)
{
  const nsdae_blocks *b = &s->system->blocks;
  const nsdae_rows *rows = &s->here->by.normal;
  double most = 0;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int block = rows->block[p];
    most = fmax(most, nsdae_largest(nsdae_blocks_size(b, block), s->here->v + b->first[block]));
  }
  return most;
}

void nsdae_event_unresolved(nsdae_event_setting *s, int i, double velocity)
{
  nsdae_unresolved *to = &s->result->unresolved;
  const double *v = s->here->v;
  double tol = nsdae_event_velocity_size(s);
  if (to->velocity > 0) return;
  *to = (nsdae_unresolved){.contact = nsdae_system_index(s->system, NSDAE_NAME_CONTACT, i),
                           .t = nsdae_terms_time(s->here),
                           .velocity = velocity,
                           .tol = tol,
                           .least = s->options->rtol * velocity / (NSDAE_EVENT_SLOW * tol)};
  nsdae_system_called(s->system, NSDAE_NAME_CONTACT, i, to->called);
  for (int j = 1; j < s->system->dims.nv; j++)
    if (fabs(v[j]) > fabs(v[to->fastest])) to->fastest = j;
}
