#include "failure.hpp"

#include "callbacks.hpp"

namespace nsdae_python
{

namespace
{

// The module nsdae._errors, which makes the exceptions.
nb::object errors()
{
  return nb::module_::import_("nsdae._errors");
}

} // namespace

nb::object make_callback_error(nb::object cause)
{
  return errors().attr("of_callback")(cause);
}

void raise(const nsdae_error &error)
{
  if (exception_pending()) raise_pending();
  nb::object made = errors().attr("of_record")(error.status, error.code, error.index, error.time,
                                               nb::str(error.argument), nb::str(error.where),
                                               nb::str(error.text));
  PyErr_SetObject(reinterpret_cast<PyObject *>(Py_TYPE(made.ptr())), made.ptr());
  throw nb::python_error();
}

void check(int status, const nsdae_error *error)
{
  if (status >= 0) return;
  nsdae_error said = error ? *error : nsdae_error();
  if (said.status != status) { // of functions that keep no record
    said = nsdae_error();
    said.status = status;
    said.index = -1;
    snprintf(said.text, sizeof said.text, "%s", nsdae_status_message(status));
  }
  raise(said);
}

void bind_failure(nb::module_ &m)
{
  nb::dict names;
#define NSDAE_PYTHON_STATUS(name, value, message) names[&#name[6]] = value;
  NSDAE_STATUS_LIST(NSDAE_PYTHON_STATUS)
#undef NSDAE_PYTHON_STATUS
  m.attr("STATUS") = names;
  m.def("status_message", &nsdae_status_message);
}

} // namespace nsdae_python
