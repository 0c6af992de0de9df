#include "simulation.h"

#include <stdio.h>
#include <stdlib.h>

#include "interrupt_signal.h"

static int init(const driver_model *model, nsdae_sim *sim, nsdae_error *error)
{
  nsdae_dims dims;
  nsdae_sim_get_dims(sim, &dims);
  double *q0 = calloc((size_t)dims.nq + (size_t)dims.nv, sizeof *q0), *v0 = q0 + dims.nq;
  if (!q0) {
    snprintf(error->text, sizeof error->text, "out of memory");
    return error->status = NSDAE_E_MEMORY;
  }
  model->start(model->base, q0, v0);
  int status = nsdae_sim_init(sim, 0, q0, v0);
  if (status < 0) *error = *nsdae_sim_error(sim);
  free(q0);
  return status;
}

int simulation_make(const driver_model *model, const nsdae_sim_options *options,
                    nsdae_system **system, nsdae_sim **sim, nsdae_error *error)
{
  *system = NULL;
  *sim = NULL;
  int status = model->build(model->base, system, error);
  if (status == NSDAE_OK) status = nsdae_sim_create(*system, options, sim, error);
  return status < 0 ? status : init(model, *sim, error);
}

void simulation_release(nsdae_system **system, nsdae_sim **sim)
{
  nsdae_sim_destroy(sim);
  nsdae_system_destroy(system);
}

int simulation_run(nsdae_sim *sim, double t_end, nsdae_error *error)
{
  nsdae_sim_observe(sim, interrupt_observe, NULL);
  nsdae_sim_set_interrupt(sim, interrupt_asked, NULL); /* steps can be long */
  int status = nsdae_sim_run(sim, t_end);
  if (status < 0) *error = *nsdae_sim_error(sim);
  if (status == NSDAE_STOPPED) return interrupt_status(sim, error);
  return status > 0 ? NSDAE_OK : status; /* warnings are in the report */
}
