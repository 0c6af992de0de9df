/* What a trajectory file says of the run: attributes of the root, options, parameters, settings. */
#ifndef NSDAE_IO_DESCRIPTION_H
#define NSDAE_IO_DESCRIPTION_H

#include <nsdae/trajectory.h>

#include "hdf5_data.h"
#include "formula.h"

/* Writes it into a new file. */
void nsdae_description_write(nsdae_h5 *h5, const nsdae_sim *sim, const nsdae_trajectory_info *info);

/* Whether a run can continue in the file; NSDAE_E_IO: it has another format version. */
void nsdae_description_check(nsdae_h5 *h5);

/* The attribute status of the root, of a run that returned run_status. */
void nsdae_description_set_ended(nsdae_h5 *h5, int run_status);

/* For a restart: the settings of a run (model, sizes, options, parameters) as lines
 * "group/key=value" in one dataset of bytes. A run continues in a file only if all but the group
 * "run" is the same. */
enum { NSDAE_SETTING_VALUE = NSDAE_PARAM_TEXT_SIZE };

typedef struct nsdae_setting {
  char *text; /* lines, with a zero behind */
  size_t length, room;
} nsdae_setting;

/* That of a simulation; of a file, NSDAE_E_IO: it has none. */
void nsdae_setting_make(nsdae_setting *setting, nsdae_h5 *h5, const nsdae_sim *sim,
                        const nsdae_trajectory_info *info);
void nsdae_setting_read(nsdae_setting *setting, nsdae_h5 *h5);
void nsdae_setting_write(const nsdae_setting *setting, nsdae_h5 *h5);
void nsdae_setting_release(nsdae_setting *setting);

/* Copies the value of that name, "group/key"; 0 if there is no such line. */
int nsdae_setting_find(const nsdae_setting *setting, const char *name,
                       char value[NSDAE_SETTING_VALUE]);

/* NSDAE_E_ARGUMENT names the first that differs. */
void nsdae_setting_compare(const nsdae_setting *own, const nsdae_setting *file, nsdae_h5 *h5);

/* ---- shapes_data.c: bodies that a trajectory file names, its groups /bodies and /shapes */

/* NSDAE_E_ARGUMENT with the first body that is not as the header wants it. */
void nsdae_bodies_check(nsdae_h5 *h5, int n, const nsdae_body *body,
                        const nsdae_formula_names *names);

/* Writes those that passed the check; apart: what is placed by coordinates alone goes to the group
 * /shapes, in numbers. */
void nsdae_bodies_write(nsdae_h5 *h5, int n, const nsdae_body *body,
                        const nsdae_formula_names *names, int apart);

#endif
