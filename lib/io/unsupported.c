/* Files in a library that was built without HDF5. */
#include <nsdae/friction_file.h>
#include <nsdae/lcp_file.h>
#include <nsdae/trajectory.h>

#include "errors.h"

/* Nothing here reads its arguments. */
#pragma GCC diagnostic ignored "-Wunused-parameter"

static int unsupported(const char *where, nsdae_error *error)
{
  return nsdae_error_set(error, NSDAE_E_UNSUPPORTED, where, "",
                         "this library was built without HDF5 (NSDAE_HDF5=OFF)");
}

#define UNSUPPORTED(name, arguments)  \
  int name arguments                  \
  {                                   \
    return unsupported(#name, error); \
  }

UNSUPPORTED(nsdae_trajectory_put,
            (nsdae_trajectory * trajectory, const char *path, int n, const double *values,
             const char *units, const char *description, nsdae_error *error))
UNSUPPORTED(nsdae_trajectory_put_texts,
            (nsdae_trajectory * trajectory, const char *path, int n, const char *const *texts,
             const char *description, nsdae_error *error))
UNSUPPORTED(nsdae_trajectory_set_bodies,
            (nsdae_trajectory * trajectory, int n, const nsdae_body *body, nsdae_error *error))
UNSUPPORTED(nsdae_trajectory_read_params,
            (const char *path, const char *group, const nsdae_params *table, void *base,
             nsdae_error *error))
UNSUPPORTED(nsdae_trajectory_flush, (nsdae_trajectory * trajectory, nsdae_error *error))
UNSUPPORTED(nsdae_lcp_write, (const char *path, const nsdae_lcp_problem *problem,
                              const nsdae_lcp_origin *origin, nsdae_error *error))
UNSUPPORTED(nsdae_friction_write, (const char *path, const nsdae_friction_problem *problem,
                                   const nsdae_friction_points *points,
                                   const nsdae_friction_origin *origin, nsdae_error *error))

int nsdae_trajectory_create(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                            nsdae_trajectory **trajectory, nsdae_error *error)
{
  if (trajectory) *trajectory = NULL;
  return nsdae_error_set(error, NSDAE_E_UNSUPPORTED, "nsdae_trajectory_create", "path",
                         "cannot write '%.100s': this library was built without HDF5 "
                         "(NSDAE_HDF5=OFF)",
                         path ? path : "");
}

int nsdae_trajectory_resume(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                            nsdae_trajectory **trajectory, nsdae_error *error)
{
  if (trajectory) *trajectory = NULL;
  return unsupported("nsdae_trajectory_resume", error);
}

int nsdae_trajectory_close(nsdae_trajectory **trajectory, int run_status, nsdae_error *error)
{
  nsdae_error_clear(error);
  return NSDAE_OK;
}

int nsdae_lcp_read(const char *path, nsdae_lcp_file *file, nsdae_error *error)
{
  if (file) *file = (nsdae_lcp_file){0};
  return unsupported("nsdae_lcp_read", error);
}

int nsdae_friction_read(const char *path, nsdae_friction_file *file, nsdae_error *error)
{
  if (file) *file = (nsdae_friction_file){0};
  return unsupported("nsdae_friction_read", error);
}
