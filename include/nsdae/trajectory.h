/* nsdae: trajectories in HDF5 files. BSD-3-Clause. docs/trajectory.md has the layout. */
#ifndef NSDAE_TRAJECTORY_H
#define NSDAE_TRAJECTORY_H

#include <nsdae/params.h>
#include <nsdae/shape.h>
#include <nsdae/sim.h>
#include <nsdae/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A trajectory file open for writing; opaque. */
typedef struct nsdae_trajectory nsdae_trajectory;

/* Model and settings of a trajectory file. */
typedef struct nsdae_trajectory_info {
  const char *model;              /* e.g. "pendulum" */
  const nsdae_params *parameters; /* table of the model's parameters, or NULL; its entries must
                                     outlive the trajectory */
  const void *parameters_base;    /* the struct that the table describes */
  int live;                       /* 1: readable during the run (SWMR mode of HDF5; readers need
                                     HDF5 1.10 or later) */
  int every;    /* writes the start, every n-th step after it, and the last state on close; all
                   impacts and mode transitions are written. 0 and 1: every step */
  int compress; /* 1 (fast) .. 9 (small): compression of records in chunks of 1024; a killed run
                   loses more of them. 0: none. Not with live */
  double t_end; /* end time of the run [s], for a resumed run; 0: unknown */
  int contact_forces; /* 1: writes points and forces of the contacts, as
                         nsdae_sim_get_contact_forces has them. 0: none */
} nsdae_trajectory_info;

/* Creates the file (replaces an existing one) and adds an observer to sim. sim must live until the
 * file is closed. Several threads may each write a file if HDF5 is thread-safe.
 *
 * - NSDAE_E_IO: the file cannot be created; the text has the cause
 * - NSDAE_E_UNSUPPORTED: built without HDF5
 * - NSDAE_E_ARGUMENT; contact_forces = 1, but the system was not made by nsdae_bodies_system
 * - NSDAE_E_MEMORY */
NSDAE_API int nsdae_trajectory_create(nsdae_sim *sim, const char *path,
                                      const nsdae_trajectory_info *info,
                                      nsdae_trajectory **trajectory, nsdae_error *error);

/* Resumes the file of an earlier run, which may have been killed at any time. Sets sim to the
 * newest state in the file (nsdae_sim_set_state) and adds an observer to sim. Records written a
 * second time are identical byte for byte. sim and info must be those of the run that created the
 * file, except t_end. every, compress and contact_forces are those of the file (0: unchanged). A
 * file created with live has no state. On an error the file is unchanged:
 *
 * - NSDAE_E_ARGUMENT: the text names the model, size, option or parameter that differs
 * - NSDAE_E_IO: the file cannot be read, has no complete state, or was made by version 0.2 */
NSDAE_API int nsdae_trajectory_resume(nsdae_sim *sim, const char *path,
                                      const nsdae_trajectory_info *info,
                                      nsdae_trajectory **trajectory, nsdae_error *error);

/* Reads the settings of the run that created a file into the struct at base. group is "options",
 * "parameters" or "run" (t_end, every, compress, contact_forces). Only keys of the table are read.
 * NSDAE_E_IO: no such file, or it has no such settings; NSDAE_E_ARGUMENT: a value is out of the
 * table's range. */
NSDAE_API int nsdae_trajectory_read_params(const char *path, const char *group,
                                           const nsdae_params *table, void *base,
                                           nsdae_error *error);

/* Adds a dataset of n values at a path such as "/compare/error". Missing groups are created. A
 * dataset that was put before the run was resumed is replaced. Not available with live. NSDAE_E_IO,
 * NSDAE_E_ARGUMENT, NSDAE_E_UNSUPPORTED. */
NSDAE_API int nsdae_trajectory_put(nsdae_trajectory *trajectory, const char *path, int n,
                                   const double *values, const char *units, const char *description,
                                   nsdae_error *error);
/* Adds a dataset of n texts, like nsdae_trajectory_put. */
NSDAE_API int nsdae_trajectory_put_texts(nsdae_trajectory *trajectory, const char *path, int n,
                                         const char *const *texts, const char *description,
                                         nsdae_error *error);

/* Sets the bodies (n >= 0), once and before the first step. They replace those of the system
 * (nsdae_system_add_body), which the file has by default. All data are copied.
 *
 * - NSDAE_E_ARGUMENT: the text names the body, its field and the error; index is the body's number
 * - NSDAE_E_STATE: bodies are set, or a step was taken (also by the run that was resumed)
 * - NSDAE_E_MEMORY, NSDAE_E_IO, NSDAE_E_UNSUPPORTED */
NSDAE_API int nsdae_trajectory_set_bodies(nsdae_trajectory *trajectory, int n,
                                          const nsdae_body *body, nsdae_error *error);

/* Writes buffered data. All records so far are then in the file, even if the program crashes. Runs
 * flush four times a second. NSDAE_E_IO. */
NSDAE_API int nsdae_trajectory_flush(nsdae_trajectory *trajectory, nsdae_error *error);

/* Writes buffered data, sets the attribute `status`, closes the file and sets *trajectory to NULL.
 * Memory is freed in any case. `status` depends on run_status:
 *
 * - "stopped": NSDAE_STOPPED
 * - "interrupted": NSDAE_E_INTERRUPTED
 * - "failed": any other value < 0
 * - "complete": any other value
 *
 * NSDAE_E_IO: not all data were written; the text says what the file contains. NSDAE_E_STATE:
 * called from a callback, or while another thread steps sim; the trajectory stays open. */
NSDAE_API int nsdae_trajectory_close(nsdae_trajectory **trajectory, int run_status,
                                     nsdae_error *error);

#ifdef __cplusplus
}
#endif
#endif
