/* nsdae: trajectories in HDF5 files. BSD-3-Clause. The layout is in docs/trajectory.md. */
#ifndef NSDAE_TRAJECTORY_H
#define NSDAE_TRAJECTORY_H

#include <nsdae/params.h>
#include <nsdae/shape.h>
#include <nsdae/sim.h>
#include <nsdae/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A trajectory file that is being written; opaque. */
typedef struct nsdae_trajectory nsdae_trajectory;

/* What the file says of the model. */
typedef struct nsdae_trajectory_info {
  const char *model;              /* e.g. "pendulum" */
  const nsdae_params *parameters; /* table over the model's parameters, or NULL; its
                                     entries must live as long as the trajectory */
  const void *parameters_base;    /* the struct that the table describes */
  int live;                       /* 1: can be read while it is written (HDF5's SWMR mode, which
                                     needs HDF5 1.10 or later to read) */
  int every;    /* keeps the start and each every-th step after it, and the last state when the file
                   is closed; impacts and changes of mode are all kept. 0 as 1: every step */
  int compress; /* 1 (fast) .. 9 (small): records are compressed and go to the file by 1024, so that
                   a killed run loses more of them; 0: not. Not with live */
  double t_end; /* where the run is to end [s], for whoever goes on with it; 0: not known */
} nsdae_trajectory_info;

/* Makes the file (replacing one of that name) and adds itself to the observers of sim, which must
 * live until it is closed. Several threads may write a file each where HDF5 was built thread-safe.
 * NSDAE_E_IO: the file cannot be made, the text says why; NSDAE_E_UNSUPPORTED: the library was
 * built without HDF5; NSDAE_E_MEMORY; NSDAE_E_ARGUMENT. */
NSDAE_API int nsdae_trajectory_create(nsdae_sim *sim, const char *path,
                                      const nsdae_trajectory_info *info,
                                      nsdae_trajectory **trajectory, nsdae_error *error);

/* Goes on in the file of an earlier run, which may have been killed at any moment: sets sim to the
 * newest state in it (nsdae_sim_set_state) and adds itself to the observers; rows that are written
 * a second time have the bytes that they had. sim and info must be those of the run that made the
 * file, but for t_end; every and compress are the file's (0: as it is). A file that was made live
 * has no state. NSDAE_E_ARGUMENT names the model, size, option or parameter that is another one;
 * NSDAE_E_IO: the file cannot be read or has no whole state. Then the file is as it was. */
NSDAE_API int nsdae_trajectory_resume(nsdae_sim *sim, const char *path,
                                      const nsdae_trajectory_info *info,
                                      nsdae_trajectory **trajectory, nsdae_error *error);

/* Reads what the run that made a file was told into the struct at base: of the group "options",
 * "parameters" or "run" (t_end, every, compress) those keys that the table has. NSDAE_E_IO: no such
 * file, or it says nothing; NSDAE_E_ARGUMENT: a value is outside the table's range. */
NSDAE_API int nsdae_trajectory_read_params(const char *path, const char *group,
                                           const nsdae_params *table, void *base,
                                           nsdae_error *error);

/* Adds a dataset of n values of one's own, at a path such as "/compare/error"; groups are made as
 * needed; one that a run had put before it was gone on with is replaced. Not while the file is
 * live. NSDAE_E_IO, NSDAE_E_ARGUMENT, NSDAE_E_UNSUPPORTED. */
NSDAE_API int nsdae_trajectory_put(nsdae_trajectory *trajectory, const char *path, int n,
                                   const double *values, const char *units, const char *description,
                                   nsdae_error *error);
/* The same of n texts. */
NSDAE_API int nsdae_trajectory_put_texts(nsdae_trajectory *trajectory, const char *path, int n,
                                         const char *const *texts, const char *description,
                                         nsdae_error *error);

/* Names the bodies, n >= 0, once and before the first step, in place of those that the system has
 * (nsdae_system_add_body), which are in the file by themselves; all is copied. NSDAE_E_ARGUMENT:
 * the text names the body, what of it and what is wrong, index is its number; NSDAE_E_STATE: bodies
 * were named before, or a step was taken, also by the run that this one goes on with;
 * NSDAE_E_MEMORY, NSDAE_E_IO, NSDAE_E_UNSUPPORTED. */
NSDAE_API int nsdae_trajectory_set_bodies(nsdae_trajectory *trajectory, int n,
                                          const nsdae_body *body, nsdae_error *error);

/* Writes what is buffered: from here on the file has every record so far, whatever becomes of the
 * program. Runs do it four times a second by themselves. NSDAE_E_IO. */
NSDAE_API int nsdae_trajectory_flush(nsdae_trajectory *trajectory, nsdae_error *error);

/* Writes what is buffered, sets the attribute `status` to how the run ended: "stopped" for
 * run_status NSDAE_STOPPED, "interrupted" for NSDAE_E_INTERRUPTED, "failed" for what else is < 0,
 * "complete" for the rest; closes the file and sets *trajectory to NULL. The memory is released in
 * any case. NSDAE_E_IO: not all could be written; the text says what the file holds. From a
 * callback, or while another thread steps sim: NSDAE_E_STATE, and the trajectory stays open. */
NSDAE_API int nsdae_trajectory_close(nsdae_trajectory **trajectory, int run_status,
                                     nsdae_error *error);

#ifdef __cplusplus
}
#endif
#endif
