#include "report.h"

#include <math.h>
#include <string.h>

/* Longest table of impacts; the trajectory file has all of them. */
enum { ROWS_MAX = 40 };

static void print_parameters(const settings *s)
{
  const nsdae_params *table = s->model->parameters;
  printf("%s: %s\n", s->model->name, s->model->summary);
  for (int i = 0; i < table->n; i++) {
    char value[NSDAE_PARAM_TEXT_SIZE];
    const char *unit = table->entry[i].unit;
    nsdae_params_format(&table->entry[i], s->model->base, value, sizeof value);
    printf("  %-10s %12s %-6s %s\n", table->entry[i].key, value, strcmp(unit, "1") ? unit : "",
           table->entry[i].help);
  }
  printf("method %s (%s)\ndt %g s, to %g s\n\n", nsdae_method_name(s->options.method),
         nsdae_method_summary(s->options.method), s->options.dt, s->t_end);
}

static void print_header(const report *r)
{
  printf("%6s %12s", "impact", "time [s]");
  if (r->contacts > 1) printf(" %8s", "contact");
  printf(" %14s", "impulse [N s]");
  if (r->tangents > 0) printf(" %14s", "friction [N s]");
  printf(" %14s %14s", "before [m/s]", "after [m/s]");
  if (r->exact) printf(" %14s %14s %10s", "exact time", "exact impulse", "error");
  printf("\n");
}

/* Completed part of a continued run. */
static double part_of(const settings *s, const nsdae_sim *sim)
{
  nsdae_record now;
  return nsdae_sim_get_record(sim, &now) == NSDAE_OK ? now.time / s->t_end : 0;
}

void report_begin(report *r, const settings *s, const nsdae_sim *sim)
{
  nsdae_dims dims;
  nsdae_sim_get_dims(sim, &dims);
  driver_exact first;
  *r = (report){.settings = s,
                .contacts = dims.k,
                .tangents = dims.nt,
                .exact = s->model->exact && s->model->exact(s->model->base, 0, &first)};
  brief_begin(&r->brief, s);
  bar_begin(&r->bar, s->quiet);
  r->bar.begin = part_of(s, sim);
  if (s->quiet) return;
  print_parameters(s);
  if (dims.k > 0) print_header(r);
}

static void print_exact(const report *r, double impulse)
{
  const driver_model *model = r->settings->model;
  driver_exact exact;
  if (!model->exact || !model->exact(model->base, r->rows, &exact)) return;
  printf(" %14.9f %14.9f %9.3f%%", exact.time, exact.normal_impulse,
         100 * (impulse - exact.normal_impulse) / exact.normal_impulse);
}

static void print_impact(report *r, const nsdae_impact *impact)
{
  if (r->contacts > 0 && r->rows < ROWS_MAX) {
    printf("%6d %12.6f", r->rows, impact->time);
    if (r->contacts > 1) printf(" %8d", impact->contact);
    printf(" %14.7f", impact->normal_impulse);
    if (r->tangents == 1) printf(" %14.7f", impact->tangential_impulse[0]);
    if (r->tangents == 2)
      printf(" %14.7f", hypot(impact->tangential_impulse[0], impact->tangential_impulse[1]));
    printf(" %14.7f %14.7f", impact->velocity_before, impact->velocity_after);
    print_exact(r, impact->normal_impulse);
    printf("\n");
  }
  r->rows++;
}

int report_observe(const nsdae_record *record, nsdae_error *error, void *user)
{
  report *r = user;
  const driver_model *model = r->settings->model;
  (void)error;
  if (model->follow) model->follow(model->base, record);
  if (r->settings->brief) brief_observe(&r->brief, record);
  if (r->settings->quiet) return 0;
  if (record->impacts > 0) bar_clear(&r->bar);
  for (int i = 0; i < record->impacts; i++) {
    r->fastest = fmax(r->fastest, -record->impact[i].velocity_before);
    print_impact(r, &record->impact[i]);
  }
  bar_move(&r->bar, record->time / r->settings->t_end, record->time);
  return 0;
}

static void print_figure(const char *what, double value, const char *unit, const char *kind,
                         int item)
{
  printf("%s %.2e%s", what, value, unit);
  if (item >= 0) printf(" (%s %d)", kind, item);
}

/* Largest residuals of all records, with their contacts and constraints. */
static void print_certificate(const nsdae_certificate *c, const nsdae_dims *d, int listed)
{
  if (d->k > 0 || listed) {
    print_figure("worst pull", c->pull, " N s", "contact", listed ? -1 : c->pull_contact);
    print_figure(", friction outside its cone", c->cone_excess, " N s", "contact",
                 listed ? -1 : c->cone_contact);
    print_figure(", complementarity", c->complementarity, " J", "contact",
                 listed ? -1 : c->complementarity_contact);
    printf("\n");
  }
  if (d->m == 0) return;
  print_figure("worst constraint rate", c->constraint_rate, "", "constraint", c->rate_constraint);
  printf("\n");
}

static void print_energy(const nsdae_certificate *c)
{
  printf("energy: work %+.3e J, dissipated %.3e J, unexplained %+.3e J (< 0: lost by the method)\n",
         c->work, c->dissipated, c->unexplained);
}

/* Warnings of the run; the first has its values. */
static void say_warnings(const nsdae_sim *sim, const nsdae_stats *stats)
{
  static const char *const kinds[] = {"energy", "penetration", "drift"};
  const nsdae_error *first = nsdae_sim_error(sim);
  if (first->status > 0) printf("warning: %s\n", first->text);
  for (int i = 0; i < 3; i++)
    if (stats->warnings & 1 << i)
      printf("warning: %s of this run exceeds the bound of the method\n", kinds[i]);
  if (stats->warnings & 8) printf("warning: friction forces of this run are not unique\n");
  if (stats->warnings & 16) printf("warning: impacts of this run were merged\n");
}

/* Time-stepping methods detect a contact at the end of the step in which it closes. */
static int is_time_stepping(int method)
{
  return method == NSDAE_METHOD_IMPLICIT || method == NSDAE_METHOD_IMPLICIT_PRINTED ||
         method == NSDAE_METHOD_MOREAU;
}

/* Errors to expect from the method, and remarks of the model. */
static void print_remarks(const report *r, const nsdae_stats *stats)
{
  const driver_model *model = r->settings->model;
  const nsdae_sim_options *options = &r->settings->options;
  const char *remark = model->remark ? model->remark(model->base) : NULL;
  if (remark) printf("%s\n", remark);
  if (!is_time_stepping(options->method) || r->rows == 0 || r->contacts == 0) return;
  printf("impact times are up to two steps late with this method%s\n",
         r->exact ? "; the errors grow if impacts follow each other soon" : "");
  if (stats->worst_penetration > 0)
    printf("penetration up to %.1e m is expected with time stepping: two steps of travel\n",
           2 * r->fastest * options->dt);
  printf("a smaller --dt reduces both errors, --method event locates the impacts\n");
}

void report_end(report *r, const nsdae_sim *sim, const nsdae_system *system)
{
  nsdae_stats stats;
  nsdae_dims dims;
  nsdae_sim_get_stats(sim, &stats);
  nsdae_sim_get_dims(sim, &dims);
  bar_clear(&r->bar);
  if (r->settings->brief) brief_end(&r->brief, sim, system);
  if (r->settings->quiet) return;
  if (r->contacts > 0 && r->rows > ROWS_MAX) printf("  ... and %d more\n", r->rows - ROWS_MAX);
  if (r->contacts > 0 && r->rows == 0) printf("  none\n");
  printf("\n%ld steps (%ld smooth, %ld with contact), %ld LCPs, %ld iterations, %ld impacts\n",
         stats.steps, stats.smooth_steps, stats.contact_steps, stats.lcps, stats.iterations,
         stats.impacts);
  printf("worst LCP residual %.2e (tolerance %.1e), constraint drift %.2e m, penetration %.2e m\n",
         stats.worst_residual, stats.contact_tol, stats.worst_drift, stats.worst_penetration);
  print_certificate(&stats.certificate, &dims, stats.contact_capacity > 0);
  if (stats.rank < dims.m)
    printf("rank of the constraints %d of %d: redundant constraints have least-norm reactions\n",
           stats.rank, dims.m);
  if (stats.rank < dims.m)
    printf("smallest sine of a retained constraint %.1e, largest of a discarded one %.1e\n",
           stats.rank_retained, stats.rank_discarded);
  if (stats.rank < stats.rank_most)
    printf("the rank is %d at times: redundant constraints drift apart; try a larger rank_tol\n",
           stats.rank_most);
  if (stats.accumulations > 0)
    printf("%ld accumulation%s of impacts (Zeno) came to rest\n", stats.accumulations,
           stats.accumulations > 1 ? "s" : "");
  if (stats.accumulations_early > 0)
    printf("%ld of them were closed early: their velocities were within rtol and atol, or they "
           "chattered\n",
           stats.accumulations_early);
  if (stats.fallback_steps > 0)
    printf("%ld steps were taken by implicit: too many events, or events without progress\n",
           stats.fallback_steps);
  if (stats.inexact_steps > 0)
    printf("%ld steps left a contact problem above its tolerance, see contact_give\n",
           stats.inexact_steps);
  if (stats.frozen_steps > 0)
    printf("%ld steps of implicit froze their contacts after 20 iterations\n", stats.frozen_steps);
  say_warnings(sim, &stats);
  print_remarks(r, &stats);
  printf("energy balance %+.3e J (energy + dissipated - start)\n", stats.energy_balance);
  print_energy(&stats.certificate);
  printf("time %.3g s, %.3g us a step\n", stats.wall_time,
         stats.steps ? 1e6 * stats.wall_time / (double)stats.steps : 0);
  if (r->settings->model->conclude) r->settings->model->conclude(r->settings->model->base);
  fflush(stdout); /* before a comparison, which can take long */
}
