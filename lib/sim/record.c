/* Records, impacts, certificates and statistics of a point, from its result alone. */
#include <math.h>
#include <string.h>

#include "sim_impl.h"

enum {
  RECORD_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_PHI | NSDAE_TERM_GAP | NSDAE_TERM_POTENTIAL,
  ALL_TERMS = RECORD_TERMS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T |
              NSDAE_TERM_OMEGA | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS |
              NSDAE_TERM_SLIDE,
  EVERY_TERM = ALL_TERMS | NSDAE_TERM_ACCELERATION
};

static void fill_record(nsdae_point *p)
{
  const nsdae_result *r = &p->result;
  const nsdae_terms *end = &r->end;
  p->record = (nsdae_record){.step = p->accounts.step,
                             .time = end->t,
                             .q = end->q,
                             .v = end->v,
                             .multiplier = r->multiplier,
                             .gap = end->gap,
                             .normal_impulse = r->impulses.normal,
                             .tangential_impulse = r->impulses.tangential,
                             .mode = r->impulses.mode,
                             .slide_impulse = r->impulses.slide_impulse,
                             .slide_mode = r->impulses.slide_mode,
                             .kinetic = nsdae_terms_kinetic(end),
                             .potential = end->potential,
                             .dissipated = p->accounts.dissipated,
                             .lcp_residual = r->worst_residual,
                             .constraint_drift = nsdae_terms_drift(end),
                             .penetration = nsdae_terms_penetration(end),
                             .impact = r->impact,
                             .impacts = r->impacts,
                             .change = r->change,
                             .changes = r->changes};
}

static void count(nsdae_stats *stats, const nsdae_counters *c)
{
  stats->lcps += c->lcps;
  stats->lcp_pivots += c->lcp_pivots;
  stats->iterations += c->iterations;
  stats->events += c->events;
  stats->accumulations += c->accumulations;
  stats->fallback_steps += c->fallbacks;
  stats->mass_evals += c->evals.mass;
  stats->force_evals += c->evals.force;
  stats->jacobian_evals += c->evals.jacobian;
  if (c->rank < stats->rank) stats->rank = c->rank;
  if (c->rank_most > stats->rank_most) stats->rank_most = c->rank_most;
}

static void certify(nsdae_stats *stats, const nsdae_record *r)
{
  stats->worst_residual = fmax(stats->worst_residual, r->lcp_residual);
  stats->worst_drift = fmax(stats->worst_drift, r->constraint_drift);
  stats->worst_penetration = fmax(stats->worst_penetration, r->penetration);
  stats->energy_balance = r->kinetic + r->potential + r->dissipated - stats->energy_start;
}

/* A contact hits where it had no impulse in the step before (or the method says so) and closed
 * faster than the threshold. */
static void find_impacts(const nsdae_impulses *before, nsdae_result *result, double slow)
{
  const nsdae_impulses *r = &result->impulses;
  const nsdae_dims *dims = &result->end.system->dims;
  for (int i = 0; i < dims->k; i++) {
    int fresh = before->normal[i] == 0 || r->impact[i];
    if (!(r->normal[i] > 0) || !fresh || !(r->before[i] < -slow)) continue;
    nsdae_impact *impact = &result->impact[result->impacts++];
    *impact = (nsdae_impact){.time = result->end.t,
                             .contact = i,
                             .normal_impulse = r->normal[i],
                             .velocity_before = r->before[i],
                             .velocity_after = r->after[i]};
    for (int j = 0; j < dims->nt; j++)
      impact->tangential_impulse[j] = r->tangential[i * dims->nt + j];
  }
}

int nsdae_point_start(nsdae_sim *sim, nsdae_point *point)
{
  nsdae_terms *start = &point->result.end;
  nsdae_stats *stats = &point->accounts.stats;
  int status = nsdae_terms_need(start, ALL_TERMS);
  if (status == NSDAE_OK) status = nsdae_terms_symmetric(start);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(&sim->stepper, start, start->M);
  if (status < 0) return status;
  point->accounts = (nsdae_accounts){.grid_start = start->t};
  fill_record(point);
  stats->energy_start = point->record.kinetic + point->record.potential;
  stats->rank = sim->system->dims.m;
  status = nsdae_watch_finite(point);
  if (status < 0) return status;
  nsdae_watch_start(sim, point);
  count(stats, &point->result.counters);
  certify(stats, &point->record);
  return NSDAE_OK;
}

int nsdae_point_show(nsdae_point *point, unsigned have)
{
  nsdae_terms *end = &point->result.end;
  int status = nsdae_terms_need(end, (have & EVERY_TERM) | RECORD_TERMS);
  if (status < 0) return status;
  end->have &= have | RECORD_TERMS; /* some callbacks give two */
  fill_record(point);
  return NSDAE_OK;
}

int nsdae_point_follow(nsdae_point *before, nsdae_point *point, double impact_velocity)
{
  nsdae_result *r = &point->result;
  nsdae_accounts *a = &point->accounts;
  int status = nsdae_terms_need(&r->end, RECORD_TERMS);
  if (status < 0) return status;
  if (!r->located) find_impacts(&before->result.impulses, r, impact_velocity);
  *a = before->accounts;
  a->step++;
  a->dissipated -= r->work;
  a->stats.steps++;
  a->stats.smooth_steps += r->smooth;
  a->stats.contact_steps += !r->smooth;
  a->stats.impacts += r->impacts;
  fill_record(point);
  status = nsdae_watch_finite(point);
  if (status < 0) return status;
  count(&a->stats, &r->counters);
  certify(&a->stats, &point->record);
  return NSDAE_OK;
}
