#define _POSIX_C_SOURCE 200809L /* gmtime_r */
#include "description.h"

#include <time.h>

#include "dataset_table.h"

/* The oldest that has all that is in a file, so that older programs read what they can. */
enum { FORMAT_NUMBERED = 1, FORMAT_LISTED = 2 };

/* Attributes of the root group, which identify the file. */
static void write_root(nsdae_h5 *h5, const nsdae_sim *sim, const char *model, int method)
{
  char created[32];
  struct tm date;
  time_t now = time(NULL);
  nsdae_sizes sizes = nsdae_sizes_of(sim);
  strftime(created, sizeof created, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &date)); /* ISO 8601 */
  const char *const text[][2] = {{"format", "nsdae-trajectory"},        {"status", "running"},
                                 {"library_version", nsdae_version()},  {"model", model},
                                 {"method", nsdae_method_name(method)}, {"created", created}};
  nsdae_h5_set_int(h5, h5->file, "format_version", sizes.listed ? FORMAT_LISTED : FORMAT_NUMBERED);
  for (size_t i = 0; i < sizeof text / sizeof *text; i++)
    nsdae_h5_set_text(h5, h5->file, text[i][0], text[i][1]);
}

/* The fields of a struct that a table describes, as scalar datasets in the group. */
static void write_params(nsdae_h5 *h5, const char *group, const nsdae_params *table,
                         const void *base)
{
  char path[NSDAE_H5_PATH], text[NSDAE_PARAM_TEXT_SIZE];
  const char *const as_text = text;
  nsdae_h5_group(h5, group);
  for (int i = 0; table && base && i < table->n; i++) {
    const nsdae_param *param = &table->entry[i];
    const void *value = (const char *)base + param->offset;
    int is_number = param->type == NSDAE_PARAM_REAL || param->type == NSDAE_PARAM_INT;
    hid_t type = param->type == NSDAE_PARAM_REAL ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT;
    if (!is_number) nsdae_params_format(param, base, text, sizeof text);
    nsdae_h5_array(h5, nsdae_h5_join(path, group, param->key), is_number ? type : H5T_C_S1, 0, NULL,
                   is_number ? value : &as_text, param->unit, param->help);
  }
}

void nsdae_description_write(nsdae_h5 *h5, const nsdae_sim *sim, const nsdae_trajectory_info *info)
{
  nsdae_sim_options options;
  nsdae_sim_get_options(sim, &options);
  write_root(h5, sim, info->model ? info->model : "", options.method);
  write_params(h5, "/options", nsdae_sim_options_table(), &options);
  write_params(h5, "/parameters", info->parameters, info->parameters_base);
}

void nsdae_description_set_ended(nsdae_h5 *h5, int run_status)
{
  nsdae_h5_set_text(h5, h5->file, "status",
                    run_status == NSDAE_STOPPED         ? "stopped"
                    : run_status >= 0                   ? "complete"
                    : run_status == NSDAE_E_INTERRUPTED ? "interrupted"
                                                        : "failed");
}
