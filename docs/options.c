/* Prints the page of the library's options from their own table, so that it cannot be stale. */
#include <nsdae/nsdae.h>
#include <stdio.h>

static void print_row(const nsdae_param *p, const nsdae_sim_options *defaults)
{
  char value[NSDAE_PARAM_TEXT_SIZE], range[NSDAE_PARAM_TEXT_SIZE];
  nsdae_params_format(p, defaults, value, sizeof value);
  nsdae_params_range(p, range, sizeof range);
  printf("| `%s` | `%s` | %s | %s | %s |\n", p->key, value, p->unit, range, p->help);
}

int main(void)
{
  nsdae_sim_options defaults;
  const nsdae_params *table = nsdae_sim_options_table();
  nsdae_sim_options_default(&defaults);
  printf("# Options\n\nOf a simulation: set by name with `nsdae_sim_options_set`, or the fields of "
         "`nsdae_sim_options`; in the programs\nwith `--set NAME=VALUE` or a file of parameters. A "
         "value outside its range is refused, and named.\n\n"
         "| option | default | unit | range | meaning |\n|---|---|---|---|---|\n");
  for (int i = 0; i < table->n; i++) print_row(&table->entry[i], &defaults);
  printf("\nThe methods:\n\n| `method` | |\n|---|---|\n");
  for (int i = 0; nsdae_method_name(i); i++)
    printf("| `%s` | %s |\n", nsdae_method_name(i), nsdae_method_summary(i));
  return 0;
}
