#include "brief.h"

#include <math.h>
#include <stdio.h>

void brief_begin(brief *b, const settings *s)
{
  *b = (brief){.settings = s};
}

/* Reference states are taken at records of their time: up to rounding, multiples of the step. */
static void pass_states(brief *b, const nsdae_record *r)
{
  const driver_model *model = b->settings->model;
  driver_state next;
  while (model->state(model->base, b->states, &next) && next.time <= r->time + 1e-9) {
    if (fabs(next.time - r->time) <= 1e-9) {
      b->state = next;
      b->at_state = r->q[next.coordinate];
    }
    b->states++;
  }
}

void brief_observe(brief *b, const nsdae_record *r)
{
  if (b->impacts == 0 && r->impacts > 0) b->first_impulse = r->impact[0].normal_impulse;
  b->impacts += r->impacts;
  if (b->settings->model->state) pass_states(b, r);
}

/* The model's own figure, the first impact, the last reference state; else the energy that the
 * contacts absorbed. Its exact value is the loss of energy plus the work of the forces. */
static driver_figure figure_of(const brief *b, const nsdae_stats *stats, const nsdae_system *system,
                               char *name, size_t size)
{
  const driver_model *model = b->settings->model;
  const nsdae_certificate *c = &stats->certificate;
  driver_exact first;
  driver_figure figure;
  if (model->figure && model->figure(model->base, &figure)) return figure;
  if (model->exact && b->impacts > 0 && model->exact(model->base, 0, &first))
    return (driver_figure){"impulse of the first impact", "N s", b->first_impulse,
                           first.normal_impulse};
  if (b->state.time > 0) {
    const char *named = nsdae_system_get_name(system, NSDAE_NAME_COORDINATE, b->state.coordinate);
    snprintf(name, size, "%s at %g s", named ? named : "coordinate", b->state.time);
    return (driver_figure){name, "", b->at_state, b->state.value};
  }
  return (driver_figure){"energy lost in contacts", "J", c->dissipated,
                         c->dissipated - c->unexplained};
}

void brief_end(const brief *b, const nsdae_sim *sim, const nsdae_system *system)
{
  char name[64];
  nsdae_stats stats;
  nsdae_sim_get_stats(sim, &stats);
  const driver_figure f = figure_of(b, &stats, system, name, sizeof name);
  const nsdae_error *warning = nsdae_sim_error(sim);
  printf("%-15s %6ld steps %5ld impacts %6.2f s  %s %.6g%s%s, exact %.6g\n",
         b->settings->model->name, stats.steps, stats.impacts, stats.wall_time, f.name, f.value,
         *f.unit ? " " : "", f.unit, f.exact);
  if (warning->status > 0) printf("  warning: %s\n", warning->text);
  fflush(stdout);
}
