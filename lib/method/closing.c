/* What is closed in a step: numbered contacts, one problem (contacts.h), or contacts by list, in
 * islands (world.h). */
#include <math.h>
#include <string.h>

#include "stepper.h"

int nsdae_step_close(const nsdae_step *step, nsdae_terms *terms)
{
  nsdae_stepper *s = step->tools;
  nsdae_result *r = step->result;
  if (s->world)
    return nsdae_world_close(s->world, terms, &r->closed, &r->impulses, step->state->closed,
                             step->state->impulses);
  nsdae_contacts_close(&s->contacts, terms, &r->impulses);
  return NSDAE_OK;
}

int nsdae_step_closed(const nsdae_step *step)
{
  return step->tools->world ? step->result->closed.count : step->tools->contacts.active_count;
}

int nsdae_step_contact(const nsdae_step *step, int a)
{
  return step->tools->world ? a : step->tools->contacts.active[a];
}

/* As far as what touched at the start may have come apart, twice: the fastest along its normal. */
static double reach_of(const nsdae_step *step, const nsdae_terms *terms)
{
  const nsdae_impulses *r = &step->result->impulses;
  double fastest = 0;
  for (int a = 0; a < step->result->closed.count; a++) {
    fastest = fmax(fastest, fabs(r->before[a]));
    fastest = fmax(fastest, fabs(nsdae_terms_normal_rate(step->start, a, terms->v)));
  }
  return nsdae_terms_touch(terms) + 2 * step->h * fastest;
}

int nsdae_step_meet(const nsdae_step *step, nsdae_terms *terms)
{
  nsdae_world *w = step->tools->world;
  if (!w || step->result->closed.count == 0) return NSDAE_OK;
  return nsdae_world_meet(w, terms, reach_of(step, terms));
}

void nsdae_step_before(const nsdae_step *step, const nsdae_terms *terms, const double *v,
                       int impacts_only)
{
  nsdae_stepper *s = step->tools;
  if (s->world)
    nsdae_world_before(s->world, terms, v, impacts_only);
  else
    nsdae_contacts_before(&s->contacts, terms, v, impacts_only);
}

int nsdae_step_factor(const nsdae_step *step, nsdae_terms *terms, const double *M)
{
  nsdae_stepper *s = step->tools;
  return s->world ? nsdae_world_join(s->world, terms) : nsdae_stepper_factor(s, terms, M);
}

void nsdae_step_mark_hit(const nsdae_step *step)
{
  if (step->tools->world) nsdae_world_mark_hit(step->tools->world);
}

static void count(nsdae_result *result, const nsdae_solved *solved)
{
  nsdae_counters *c = &result->counters;
  c->lcps += solved->lcps;
  c->lcp_pivots += solved->pivots;
  c->islands = solved->islands;
  c->island_contacts = solved->contacts;
  result->problem = solved->problem;
  if (solved->pile) result->pile = solved->pile;
  nsdae_count_rank(c, solved->rank, solved->kept, solved->left);
}

static int solve_world(const nsdae_step *step, const nsdae_terms *terms, const double *M,
                       const double *r, int with_contacts, double *v, double *lambda)
{
  nsdae_stepper *s = step->tools;
  int status = nsdae_world_solve(s->world, terms, M, r, with_contacts, v, s->size, lambda);
  count(step->result, &s->world->solved);
  if (status == NSDAE_OK && with_contacts)
    step->result->carried = nsdae_world_carried(s->world, terms);
  return status;
}

int nsdae_step_impact_of_world(const nsdae_step *step, nsdae_terms *terms, const double *M,
                               const double *r, double *v)
{
  nsdae_stepper *s = step->tools;
  for (int i = 0; i < s->system->dims.m; i++) s->impulse[i] = -terms->constraint.phi_t[i];
  return solve_world(step, terms, M, r, 1, v, s->impulse);
}

int nsdae_step_free(const nsdae_step *step, const nsdae_terms *terms, const double *M,
                    const double *r, double *v, double *lambda)
{
  nsdae_stepper *s = step->tools;
  if (s->world) return solve_world(step, terms, M, r, 0, v, lambda);
  memcpy(v, r, (size_t)s->kkt.n * sizeof *v);
  return nsdae_terms_solve(terms, &s->kkt, 1, v, lambda);
}

void nsdae_step_add_constraints(const nsdae_step *step, const nsdae_terms *terms, double scale,
                                int impact, double *r)
{
  const nsdae_stepper *s = step->tools;
  if (s->world)
    nsdae_world_add_constraints(s->world, terms, scale, s->impulse, r);
  else if (!impact)
    nsdae_terms_add_constraints(terms, scale, s->impulse, r);
}

void nsdae_step_add_impulse(const nsdae_step *step, const nsdae_terms *terms, double scale,
                            int skip_impacts, double *r)
{
  const nsdae_stepper *s = step->tools;
  if (s->world)
    nsdae_world_add_impulse(s->world, terms, scale, skip_impacts, r);
  else
    nsdae_contacts_add_impulse(&s->contacts, terms, scale, skip_impacts, r);
}

int nsdae_step_solve_mass(const nsdae_step *step, const double *M, double *r)
{
  nsdae_stepper *s = step->tools;
  if (s->world) return nsdae_world_solve_mass(s->world, M, r);
  nsdae_kkt_solve_mass(&s->kkt, r);
  return NSDAE_OK;
}

double nsdae_step_settled(const nsdae_step *step)
{
  const nsdae_stepper *s = step->tools;
  return s->world ? fmax(s->iteration_tol, s->world->solved.noise) : s->iteration_tol;
}
