/* The one table of the options. */
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "errors.h"
#include "sim_impl.h"

static const char *const methods[] = {"implicit", "implicit-printed", "moreau", "penalty", "event",
                                      NULL};
static const char *const laws[] = {
    "hertz", "kelvin-voigt", "hunt-crossley", "lankarani-nikravesh", "flores", NULL};
static const char *const integrators[] = {"auto", "dopri5", "dop853", "ida", NULL};
static const char *const redundant[] = {"error", "least-norm", NULL};

static const char *const automatic[] = {"auto", NULL};
static const char *const no_yes[] = {"no", "yes", NULL};
static const char *const projections[] = {"none", "constraints", "contacts", "depths",
                                          "slop", "auto",        NULL};

enum { INITIALISED = 0x6e736461 };

#define AT(field) offsetof(nsdae_sim_options, field)

static const nsdae_param entries[] = {
    {"method", "", "time integration method", NSDAE_PARAM_CHOICE, AT(method), NSDAE_METHOD_IMPLICIT,
     0, 4, 0, methods},
    {"dt", "s", "time step", NSDAE_PARAM_REAL, AT(dt), 0.005, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"baumgarte_alpha", "1/s",
     "stabilisation of Phi' in the smooth phases of implicit-printed and event", NSDAE_PARAM_REAL,
     AT(baumgarte_alpha), 20, 0, INFINITY, 0, NULL},
    {"baumgarte_beta", "1/s",
     "stabilisation of Phi in the smooth phases of implicit-printed and event", NSDAE_PARAM_REAL,
     AT(baumgarte_beta), 20, 0, INFINITY, 0, NULL},
    {"iteration_tol", "1", "relative change of q and v that ends an iteration", NSDAE_PARAM_REAL,
     AT(iteration_tol), 1e-12, DBL_EPSILON, 1e-2, 0, NULL},
    {"iteration_max", "1", "maximum number of iterations of an implicit step", NSDAE_PARAM_INT,
     AT(iteration_max), 100, 1, 1000000, 0, NULL},
    {"redundant", "", "treatment of a rank-deficient Phi_q", NSDAE_PARAM_CHOICE, AT(redundant),
     NSDAE_REDUNDANT_ERROR, 0, 1, 0, redundant},
    {"rank_tol", "1", "sine of the angle to the others below which a constraint is redundant",
     NSDAE_PARAM_REAL, AT(rank_tol), 1e-8, 0, 1, NSDAE_OPEN_MAX, NULL},
    {"contact_tol", "1",
     "tolerance of the scaled natural residual of contact problems; auto (0): 1e-10, for cones of "
     "islands of more than 11 contacts 1e-4",
     NSDAE_PARAM_REAL, AT(contact_tol), 0, DBL_EPSILON, 1e-2, NSDAE_OR_ZERO, automatic},
    {"contact_work", "1",
     "multiplications by J for the contact problem of an island; 0: 1e4 to a tolerance of 1e-5 or "
     "more, else 1e6",
     NSDAE_PARAM_REAL, AT(contact_work), 0, 0, 1e12, 0, NULL},
    {"contact_give", "1",
     "multiple of contact_tol, or of 1e-4 if that is more, up to which implicit and moreau go on "
     "with the best point; 1: of contact_tol",
     NSDAE_PARAM_REAL, AT(contact_give), 100, 1, 1e12, 0, NULL},
    {"polygon", "1",
     "edges of the friction polygon of contacts with two tangential directions; 0: second-order "
     "cone",
     NSDAE_PARAM_INT, AT(polygon), 0, 3, 32, NSDAE_OR_ZERO, NULL},
    {"impact_velocity", "m/s", "closing velocity below which a contact has no impact",
     NSDAE_PARAM_REAL, AT(impact_velocity), 1e-9, 0, INFINITY, 0, NULL},
    {"rtol", "1", "relative tolerance of penalty and event", NSDAE_PARAM_REAL, AT(rtol), 1e-8,
     1e-14, 1e-2, 0, NULL},
    /* squares of 1 / atol are summed */
    {"atol", "", "absolute tolerance of penalty and event", NSDAE_PARAM_REAL, AT(atol), 1e-10,
     1e-100, INFINITY, 0, NULL},
    {"penalty_law", "", "normal force of penalty", NSDAE_PARAM_CHOICE, AT(penalty_law), 3, 0, 4, 0,
     laws},
    {"penalty_stiffness", "N/m^n", "stiffness K of penalty", NSDAE_PARAM_REAL,
     AT(penalty_stiffness), 1e8, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"penalty_exponent", "1", "exponent n of penalty", NSDAE_PARAM_REAL, AT(penalty_exponent), 1.5,
     1, 5, 0, NULL},
    {"friction_velocity", "m/s", "velocity over which penalty regularises friction",
     NSDAE_PARAM_REAL, AT(friction_velocity), 1e-3, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"integrator", "", "integrator of penalty and event", NSDAE_PARAM_CHOICE, AT(integrator),
     NSDAE_INTEGRATOR_AUTO, 0, 3, 0, integrators},
    {"step_max", "s", "largest step of the integrator of penalty and event", NSDAE_PARAM_REAL,
     AT(step_max), INFINITY, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"accumulation_time", "s", "remaining time below which event closes an accumulation of impacts",
     NSDAE_PARAM_REAL, AT(accumulation_time), 1e-5, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"events_max", "1", "maximum number of events in one dt; beyond it implicit takes the step",
     NSDAE_PARAM_INT, AT(events_max), 10000, 1, 1e9, 0, NULL},
    {"projection", "", "projection of the end of a step of a time-stepping method",
     NSDAE_PARAM_CHOICE, AT(projection), NSDAE_PROJECTION_AUTO, 0, 5, 0, projections},
    {"start_tol", "1", "relative tolerance of the initial conditions", NSDAE_PARAM_REAL,
     AT(start_tol), 1e-6, 0, INFINITY, 0, NULL},
    {"inner_steps_max", "1", "maximum number of internal steps of penalty and event in one dt",
     NSDAE_PARAM_INT, AT(inner_steps_max), 100000, 1, 1e9, 0, NULL},
    {"start_check", "", "check for gross errors of callbacks at the start", NSDAE_PARAM_CHOICE,
     AT(start_check), 1, 0, 1, 0, no_yes},
    {"contacts_max", "1", "maximum number of contacts in a contact list", NSDAE_PARAM_INT,
     AT(contacts_max), 1 << 20, 1, 1 << 28, 0, NULL},
    {"threads", "1", "threads of a step: contact detection, islands", NSDAE_PARAM_INT, AT(threads),
     1, 1, 256, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};

const nsdae_params *nsdae_sim_options_table(void)
{
  return &table;
}

void nsdae_sim_options_default(nsdae_sim_options *options)
{
  if (!options) return;
  nsdae_params_default(&table, options);
  options->initialised = INITIALISED;
}

int nsdae_sim_options_set(nsdae_sim_options *options, const char *key, const char *value,
                          nsdae_error *error)
{
  return nsdae_params_set(&table, options, key, value, error);
}

int nsdae_sim_options_check(const nsdae_sim_options *options, nsdae_error *error)
{
  if (options->initialised != INITIALISED)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_sim_create", "options",
                           "options were not initialised: call nsdae_sim_options_default first");
  int status = nsdae_params_check(&table, options, error);
  if (status < 0 || options->projection == NSDAE_PROJECTION_NONE ||
      options->projection == NSDAE_PROJECTION_AUTO)
    return status;
  int slop = options->projection == NSDAE_PROJECTION_SLOP;
  if (slop && options->method == NSDAE_METHOD_IMPLICIT_PRINTED)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_sim_create", "projection",
                           "projection = slop is for implicit and moreau, and method is %s: set "
                           "projection = none",
                           methods[options->method]);
  if (nsdae_sim_option_matters("projection", options->method)) return status;
  return nsdae_error_set(
      error, NSDAE_E_ARGUMENT, "nsdae_sim_create", "projection",
      "projection = %s is for time-stepping methods, and method is %s: set projection = none",
      projections[options->projection], methods[options->method]);
}

int nsdae_sim_projection(const nsdae_sim_options *options)
{
  int slop = options->method == NSDAE_METHOD_IMPLICIT || options->method == NSDAE_METHOD_MOREAU;
  if (options->projection != NSDAE_PROJECTION_AUTO) return options->projection;
  return slop ? NSDAE_PROJECTION_SLOP : NSDAE_PROJECTION_NONE;
}

double nsdae_sim_option_value(const nsdae_sim_options *options, const nsdae_param *param)
{
  const char *at = (const char *)options + param->offset;
  double real;
  int whole;
  if (param->type == NSDAE_PARAM_REAL) return memcpy(&real, at, sizeof real), real;
  return memcpy(&whole, at, sizeof whole), whole;
}

/* Options by the methods that have them; those that are not here are every method's. */
enum {
  IMPLICIT = 1 << NSDAE_METHOD_IMPLICIT,
  PRINTED = 1 << NSDAE_METHOD_IMPLICIT_PRINTED,
  MOREAU = 1 << NSDAE_METHOD_MOREAU,
  PENALTY = 1 << NSDAE_METHOD_PENALTY,
  EVENT = 1 << NSDAE_METHOD_EVENT
};

static const struct {
  int methods;
  const char *keys[6];
} used[] = {
    {PRINTED | PENALTY | EVENT, {"baumgarte_alpha", "baumgarte_beta"}},
    {IMPLICIT | PRINTED | EVENT, {"iteration_max"}},
    {IMPLICIT | PRINTED | MOREAU | EVENT, {"iteration_tol", "contact_tol", "polygon"}},
    {IMPLICIT | PRINTED | MOREAU, {"projection"}},
    {IMPLICIT | MOREAU, {"contact_work", "contact_give"}},
    {PENALTY | EVENT, {"rtol", "atol", "integrator", "step_max", "inner_steps_max"}},
    {PENALTY, {"penalty_law", "penalty_stiffness", "penalty_exponent", "friction_velocity"}},
    {EVENT, {"accumulation_time", "events_max"}},
    {0, {"start_tol", "start_check", "contacts_max", "threads"}},
};

int nsdae_sim_option_matters(const char *key, int method)
{
  for (size_t i = 0; i < sizeof used / sizeof *used; i++)
    for (const char *const *of = used[i].keys; *of; of++)
      if (strcmp(*of, key) == 0) return used[i].methods >> method & 1;
  return 1;
}

/* ---- method table */

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
