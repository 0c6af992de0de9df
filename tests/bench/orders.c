/* Errors against the references at dt, dt/2, dt/4, dt/8 and the orders that they make, for every
 * time-stepping method and example; no times, so that the table is the same on every machine. */
#include <math.h>
#include <stdio.h>

#include "clearance_hinge.h"
#include "compare.h"
#include "crank_slider.h"
#include "pendulum.h"

enum { HALVINGS = 4, METHODS = 3 };

/* What is measured of a run; NaN where there is nothing to compare with. */
static double first_impulse(const comparison_run *r)
{
  return r->first_error;
}

static double states(const comparison_run *r)
{
  return r->state_error;
}

static double drift(const comparison_run *r)
{
  return r->stats.worst_drift;
}

static void print_line(const char *method, const char *what, const double error[HALVINGS])
{
  if (isnan(error[0]) || error[0] == 0) return;
  printf("  %-17s %-22s", method, what);
  for (int i = 0; i < HALVINGS; i++) printf(" %10.3e", error[i]);
  printf("   %5.2f\n", log2(error[0] / error[HALVINGS - 1]) / (HALVINGS - 1));
}

static const struct {
  const char *name;
  double (*of)(const comparison_run *);
} measures[] = {
    {"first impulse, rel.", first_impulse}, {"states", states}, {"constraint drift", drift}};

enum { MEASURES = sizeof measures / sizeof *measures };

/* Of the model with its default parameters but the one named. */
static int table(const driver_model *model, const char *title, const char *parameter,
                 const char *value, double t_end)
{
  static comparison_run run;
  settings s;
  settings_default(&s, model);
  s.t_end = t_end;
  if (parameter) settings_set(&s, parameter, value, NULL);
  double dt = s.options.dt;
  printf("%s%s%s %s, dt %g s and 2, 4, 8 times smaller, to %g s; last column: order\n", title,
         parameter ? ", " : "", parameter ? parameter : "", parameter ? value : "", dt, t_end);
  for (int method = 0; method < METHODS; method++) {
    double error[MEASURES][HALVINGS];
    for (int i = 0; i < HALVINGS; i++) {
      s.options.dt = dt / (1 << i);
      compare_one(&s, method, &run);
      if (run.status < 0) {
        printf("%s: %s\n", nsdae_method_name(method), run.text);
        return 1;
      }
      for (int j = 0; j < MEASURES; j++) error[j][i] = measures[j].of(&run);
    }
    for (int j = 0; j < MEASURES; j++)
      print_line(nsdae_method_name(method), measures[j].name, error[j]);
  }
  printf("\n");
  return 0;
}

int main(void)
{
  const char *const mu[] = {"0", "0.1", "0.3"};
  int failed = table(&pendulum_model, "pendulum", NULL, NULL, 3);
  failed |= table(&clearance_hinge_model, "clearance hinge", "r", "0.016", 0.07);
  for (int i = 0; i < 3; i++) failed |= table(&crank_slider_model, "crank-slider", "mu", mu[i], 12);
  return failed;
}
