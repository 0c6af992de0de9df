/* A point whose values are not finite does not become the state. */
#include <math.h>
#include <stdio.h>

#include "errors.h"
#include "sim_impl.h"

/* One array of a record, `each` numbers for every item of a kind (-1: of none). */
typedef struct part {
  const char *name;
  const double *value;
  int count, kind, each;
} part;

enum { OF_NONE = -1, OF_ONE = -2 }; /* kinds of what has numbers and no names, and of one number */

/* item: of a kind that entry index belongs to. */
static int refuse_nonfinite(const nsdae_result *result, const char *name, int index, double value,
                            int kind, int item)
{
  const nsdae_terms *end = &result->end;
  char place[16] = "";
  if (kind != OF_ONE) snprintf(place, sizeof place, "[%d]", index);
  nsdae_error_set(end->error, NSDAE_E_NONFINITE, "nsdae_sim", name,
                  "%s%s is %g at t = %.17g: overflow, the step was discarded", name, place, value,
                  nsdae_terms_time(end));
  if (kind >= 0) nsdae_system_name_item(end->system, kind, item, end->error);
  return nsdae_error_at(end->error, NSDAE_E_NONFINITE, index, nsdae_terms_time(end));
}

static double sum_of(const nsdae_impact *p)
{
  return p->normal_impulse + p->tangential_impulse[0] + p->tangential_impulse[1] +
         p->velocity_before + p->velocity_after + p->peak_force;
}

/* Which of the values is not finite; NSDAE_OK where none is. */
static int find_not_finite(const nsdae_point *point)
{
  const nsdae_result *result = &point->result;
  const nsdae_record *r = &point->record;
  const nsdae_dims *d = &result->end.system->dims;
  int k = r->contacts.count, contact = d->k > 0 ? NSDAE_NAME_CONTACT : OF_NONE;
  const part parts[] = {
      {"time", &r->time, 1, OF_ONE, 1},
      {"q", r->q, d->nq, NSDAE_NAME_COORDINATE, 1},
      {"v", r->v, d->nv, NSDAE_NAME_VELOCITY, 1},
      {"kinetic", &r->kinetic, 1, OF_ONE, 1},
      {"potential", &r->potential, 1, OF_ONE, 1},
      {"dissipated", &r->dissipated, 1, OF_ONE, 1},
      {"multiplier", r->multiplier, d->m, NSDAE_NAME_CONSTRAINT, 1},
      {"gap", r->contacts.gap, k, contact, 1},
      {"normal_impulse", r->contacts.normal_impulse, k, contact, 1},
      {"tangential_impulse", r->contacts.tangential_impulse, k * d->nt, contact, d->nt},
      {"frictional_joint_impulse", r->frictional_joint_impulse, d->f, NSDAE_NAME_FRICTIONAL_JOINT,
       1},
      {"certificate.work", &r->certificate.work, 1, OF_ONE, 1},
      {"certificate.unexplained", &r->certificate.unexplained, 1, OF_ONE, 1},
      {"certificate.constraint_rate", &r->certificate.constraint_rate, 1, OF_ONE, 1},
      {"certificate.complementarity", &r->certificate.complementarity, 1, OF_ONE, 1},
      {"lcp_residual", &r->lcp_residual, 1, OF_ONE, 1},
      {"constraint_drift", &r->constraint_drift, 1, OF_ONE, 1}};
  for (const part *p = parts; p < parts + sizeof parts / sizeof *parts; p++)
    for (int i = 0; i < p->count; i++)
      if (!isfinite(p->value[i]))
        return refuse_nonfinite(result, p->name, i, p->value[i], p->kind, i / p->each);
  double energy = r->kinetic + r->potential + r->dissipated;
  if (!isfinite(energy)) return refuse_nonfinite(result, "energy", 0, energy, OF_ONE, 0);
  for (int i = 0; i < r->impacts; i++)
    if (!isfinite(sum_of(&r->impact[i])))
      return refuse_nonfinite(result, "impact", i, sum_of(&r->impact[i]), contact,
                              r->impact[i].contact);
  return NSDAE_OK;
}

static double sum(const double *a, int n)
{
  double s = 0;
  for (int i = 0; i < n; i++) s += a[i];
  return s;
}

/* A finite sum has finite terms: where it is none they are looked at one by one. In it are not: the
 * energies, of which work and unexplained are sums; v, of which kinetic is none unless all are
 * finite. */
int nsdae_point_finite(const nsdae_point *point)
{
  const nsdae_record *r = &point->record;
  const nsdae_dims *d = &point->result.end.system->dims;
  int k = r->contacts.count;
  const nsdae_certificate *c = &r->certificate;
  double all = r->time + c->work + c->unexplained + r->lcp_residual + r->constraint_drift +
               c->constraint_rate + c->complementarity;
  all += sum(r->q, d->nq) + sum(r->multiplier, d->m) + sum(r->contacts.gap, k) +
         sum(r->contacts.normal_impulse, k) + sum(r->contacts.tangential_impulse, k * d->nt) +
         sum(r->frictional_joint_impulse, d->f);
  for (int i = 0; i < r->impacts; i++) all += sum_of(&r->impact[i]);
  return isfinite(all) ? NSDAE_OK : find_not_finite(point);
}
