#include "failure.hpp"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <limits>
#include <thread>

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

nb::object make_callback_error(nb::object cause, nb::object function)
{
  return errors().attr("of_callback")(cause, function);
}

nb::str readable(const char *text)
{
  const Py_ssize_t length = static_cast<Py_ssize_t>(std::strlen(text));
  PyObject *made = PyUnicode_DecodeUTF8(text, length, "replace");
  if (!made) throw nb::python_error();
  return nb::steal<nb::str>(made);
}

void raise(const nsdae_error &error)
{
  nb::object made = errors().attr("of_record")(error.status, error.code, error.index, error.time,
                                               readable(error.argument), readable(error.where),
                                               readable(error.text));
  PyErr_SetObject(reinterpret_cast<PyObject *>(Py_TYPE(made.ptr())), made.ptr());
  throw nb::python_error();
}

namespace
{

std::atomic<int> calls(0);
std::atomic<bool> interpreter_ends(false);

// As a daemon thread ends in Python: silently.
[[noreturn]] void end_thread()
{
  PyErr_SetNone(PyExc_SystemExit);
  throw nb::python_error();
}

} // namespace

void check(int status, const nsdae_error *error)
{
  if (exception_pending()) raise_pending();
  if (status == NSDAE_E_INTERRUPTED && interpreter_ends) end_thread();
  if (status >= 0) return;
  if (!error || error->status != status) refuse(status, "", nsdae_status_message(status));
  raise(*error);
}

void refuse(int status, const char *argument, const std::string &why)
{
  nsdae_error said = {};
  said.status = status;
  said.index = -1;
  said.time = std::numeric_limits<double>::quiet_NaN();
  std::snprintf(said.argument, sizeof said.argument, "%s", argument);
  std::snprintf(said.text, sizeof said.text, "%s", why.c_str());
  raise(said);
}

const char *text(const std::string &value, const char *argument)
{
  if (value.find('\0') != std::string::npos)
    refuse(NSDAE_E_ARGUMENT, argument,
           std::string(argument) + " has a NUL character: leave it out");
  return value.c_str();
}

namespace
{

// Runs check before every step whether to end. The interpreter does not wait for a long callback or
// problem.
void end_calls()
{
  using std::chrono::milliseconds;
  interpreter_ends = true;
  nb::gil_scoped_release free;
  for (int waited = 0; calls > 0 && waited < 5000; waited++)
    std::this_thread::sleep_for(milliseconds(1));
}

} // namespace

library_call::count::count()
{
  if (interpreter_ends) end_thread();
  calls++;
}

library_call::count::~count()
{
  calls--;
}

bool library_call::ending()
{
  return interpreter_ends;
}

void bind_failure(nb::module_ &m)
{
  nb::dict names;
#define NSDAE_PYTHON_STATUS(name, value, message) names[&#name[6]] = value;
  NSDAE_STATUS_LIST(NSDAE_PYTHON_STATUS)
#undef NSDAE_PYTHON_STATUS
  m.attr("STATUS") = names;
  m.def("status_message", &nsdae_status_message);
  nb::module_::import_("atexit").attr("register")(nb::cpp_function(end_calls));
  // a child has none of the threads that were in a call
  nb::module_::import_("os").attr("register_at_fork")(nb::arg("after_in_child") =
                                                          nb::cpp_function([] { calls = 0; }));
}

} // namespace nsdae_python
