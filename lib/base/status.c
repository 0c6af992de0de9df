/* Names and messages of the status codes, from the one list of status.h. */
#include <nsdae/status.h>

#include <stddef.h>

typedef struct status_text {
  int value;
  const char *name, *message;
} status_text;

static const status_text list[] = {
#define STATUS_TEXT(name, value, message) {value, #name, message},
    NSDAE_STATUS_LIST(STATUS_TEXT)
#undef STATUS_TEXT
};

static const status_text *find_status(int status)
{
  static const status_text unknown = {0, "unknown status", "unknown status"};
  for (size_t i = 0; i < sizeof list / sizeof *list; i++)
    if (list[i].value == status) return &list[i];
  return &unknown;
}

const char *nsdae_status_name(int status)
{
  return find_status(status)->name;
}

const char *nsdae_status_message(int status)
{
  return find_status(status)->message;
}
