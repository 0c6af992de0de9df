#include "models.h"

#include <stdio.h>
#include <string.h>

#include "bouncing_ball.h"
#include "clearance_hinge.h"
#include "crank_slider.h"
#include "falling_rod.h"
#include "incline.h"
#include "newtons_cradle.h"
#include "pendulum.h"
#include "rolling_ball.h"
#include "shaken_ball.h"
#include "woodpecker.h"

const driver_model *const models[] = {&bouncing_ball_model,
                                      &clearance_hinge_model,
                                      &crank_slider_model,
                                      &falling_rod_model,
                                      &incline_model,
                                      &newtons_cradle_model,
                                      &pendulum_model,
                                      &rolling_ball_model,
                                      &shaken_ball_model,
                                      &woodpecker_model,
                                      NULL};

const driver_model *models_find(const char *name, nsdae_error *error)
{
  const char *names[sizeof models / sizeof *models] = {0};
  const char *bare = strncmp(name, "nsdae-", 6) == 0 ? name + 6 : name;
  for (int i = 0; models[i]; i++) {
    names[i] = models[i]->name;
    if (strcmp(bare, names[i]) == 0) return models[i];
  }
  const char *near = nsdae_suggest_name(bare, names);
  if (near)
    snprintf(error->text, sizeof error->text, "unknown driver '%.80s'; did you mean '%s'?", name,
             near);
  else
    snprintf(error->text, sizeof error->text, "unknown driver '%.80s'; --help lists all", name);
  error->status = NSDAE_E_ARGUMENT;
  return NULL;
}
