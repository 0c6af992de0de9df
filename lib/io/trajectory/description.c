#include "description.h"

#include <stdio.h>
#include <time.h>

#include "dataset_table.h"

/* The oldest that has all that is in a file, so that older programs read what they can. */
enum { FORMAT_NUMBERED = 1, FORMAT_LISTED = 2 };

/* Room for six numbers of any length, as the compiler sees them. */
enum { DATE_LENGTH = 160 };

/* ISO 8601, UTC. gmtime's memory is shared by all threads, so the date comes from the number of the
 * day: eras of 400 years that begin on a 1st of March (Hinnant, "chrono-compatible low-level date
 * algorithms", civil_from_days). */
static void creation_time(char text[DATE_LENGTH])
{
  long now = (long)time(NULL), day = now / 86400 + 719468, second = now % 86400;
  long of_era = day % 146097;
  long year = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146096) / 365;
  long of_year = of_era - (365 * year + year / 4 - year / 100), month = (5 * of_year + 2) / 153;
  long date = of_year - (153 * month + 2) / 5 + 1;
  month = month < 10 ? month + 3 : month - 9;
  year += day / 146097 * 400 + (month <= 2);
  snprintf(text, DATE_LENGTH, "%04ld-%02ld-%02ldT%02ld:%02ld:%02ldZ", year, month, date,
           second / 3600, second / 60 % 60, second % 60);
}

/* Attributes of the root group, which identify the file. */
static int write_root(nsdae_h5 *h5, const nsdae_sim *sim, const char *model)
{
  nsdae_sim_options options;
  nsdae_sizes sizes;
  char created[DATE_LENGTH];
  nsdae_sim_get_options(sim, &options);
  nsdae_sizes_of(&sizes, sim);
  creation_time(created);
  const char *const text[][2] = {{"format", "nsdae-trajectory"},
                                 {"status", "running"},
                                 {"library_version", nsdae_version()},
                                 {"model", model},
                                 {"method", nsdae_method_name(options.method)},
                                 {"created", created}};
  int status = nsdae_h5_set_int(h5, h5->file, "format_version",
                                sizes.listed ? FORMAT_LISTED : FORMAT_NUMBERED);
  for (size_t i = 0; i < sizeof text / sizeof *text && status == NSDAE_OK; i++)
    status = nsdae_h5_set_text(h5, h5->file, text[i][0], text[i][1]);
  return status;
}

/* One field of a struct that a table describes, as a scalar dataset in the group. */
static int write_param(nsdae_h5 *h5, const char *group, const nsdae_param *param, const void *base)
{
  char path[128], text[NSDAE_PARAM_TEXT_SIZE];
  const void *value = (const char *)base + param->offset;
  snprintf(path, sizeof path, "%s/%s", group, param->key);
  if (param->type == NSDAE_PARAM_REAL)
    return nsdae_h5_scalar(h5, path, H5T_NATIVE_DOUBLE, value, param->unit, param->help);
  if (param->type == NSDAE_PARAM_INT)
    return nsdae_h5_scalar(h5, path, H5T_NATIVE_INT, value, param->unit, param->help);
  nsdae_params_format(param, base, text, sizeof text);
  return nsdae_h5_scalar(h5, path, H5T_C_S1, text, param->unit, param->help);
}

static int write_params(nsdae_h5 *h5, const char *group, const nsdae_params *table,
                        const void *base)
{
  int status = nsdae_h5_group(h5, group);
  for (int i = 0; table && base && i < table->n && status == NSDAE_OK; i++)
    status = write_param(h5, group, &table->entry[i], base);
  return status;
}

int nsdae_description_write(nsdae_h5 *h5, const nsdae_sim *sim, const nsdae_trajectory_info *info)
{
  nsdae_sim_options options;
  nsdae_sim_get_options(sim, &options);
  int status = write_root(h5, sim, info->model ? info->model : "");
  if (status == NSDAE_OK)
    status = write_params(h5, "/options", nsdae_sim_options_table(), &options);
  if (status == NSDAE_OK)
    status = write_params(h5, "/parameters", info->parameters, info->parameters_base);
  return status;
}

static int set_status(nsdae_h5 *h5, const char *status)
{
  return nsdae_h5_set_text(h5, h5->file, "status", status);
}

int nsdae_description_set_running(nsdae_h5 *h5)
{
  return set_status(h5, "running");
}

int nsdae_description_set_ended(nsdae_h5 *h5, int run_status)
{
  if (run_status == NSDAE_STOPPED) return set_status(h5, "stopped");
  if (run_status >= 0) return set_status(h5, "complete");
  return set_status(h5, run_status == NSDAE_E_INTERRUPTED ? "interrupted" : "failed");
}
