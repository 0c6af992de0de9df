/* What a system knows of the kit that made it: exact derivatives, and names for messages. */
#include "errors.h"
#include "system_impl.h"

void nsdae_system_set_maker(nsdae_system *system, const nsdae_maker *maker)
{
  system->maker = *maker;
}

int nsdae_system_sensor_size(const nsdae_system *system, int i)
{
  const nsdae_maker *m = system ? &system->maker : NULL;
  return m && i >= 0 && i < m->sensors.count ? m->sensors.size(m->of, i) : 0;
}

int nsdae_system_exact(const nsdae_system *system, int kind, int i)
{
  const nsdae_maker *m = &system->maker;
  return m->exact && m->exact(m->of, kind, i);
}

int nsdae_system_explain(const nsdae_system *system, double t, const double *q, const double *v,
                         nsdae_error *error)
{
  const nsdae_maker *m = &system->maker;
  nsdae_reason reason;
  if (!error || !m->explain || !m->explain(m->of, error->argument, t, q, v, &reason)) return 0;
  const nsdae_error as = *error;
  nsdae_error_set(error, as.status, as.where, reason.element, "%s, at t = %.17g", reason.text, t);
  error->code = as.code;
  nsdae_error_at(error, as.status, reason.index, t);
  return 1;
}
