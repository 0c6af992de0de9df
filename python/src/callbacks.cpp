#include "callbacks.hpp"

#include <algorithm>
#include <climits>
#include <cstring>

#include "failure.hpp"
#include "view.hpp"

namespace nsdae_python
{

namespace
{

thread_local PyObject *pending = nullptr;
thread_local PyObject *raised_by = nullptr; // the function, or nullptr

std::size_t length(const slot &s)
{
  return static_cast<std::size_t>(s.rows) * static_cast<std::size_t>(s.columns ? s.columns : 1);
}

frame make_frame(const std::vector<slot> &slots)
{
  frame made;
  for (const slot &s : slots) {
    double *memory = new double[length(s) + 1]();
    made.memory.push_back(memory);
    made.array.push_back(view(memory, s.rows, s.columns, s.written).release().ptr());
  }
  return made;
}

void release(frame &f)
{
  for (PyObject *array : f.array) Py_XDECREF(array);
  f.array.clear();
  f.memory.clear();
}

} // namespace

void callback::set_function(PyObject *f, const std::vector<slot> &of, bool returns)
{
  clear();
  slots = of;
  arrays = make_frame(of);
  value = returns;
  Py_INCREF(f);
  function = f;
}

void callback::set_pointer(void *address, void *with)
{
  clear();
  pointer = address;
  user = with;
}

void callback::clear()
{
  PyObject *f = function;
  function = nullptr;
  pointer = user = nullptr;
  release(arrays);
  Py_XDECREF(f);
}

void remember_exception(PyObject *function)
{
  Py_XINCREF(function);
  Py_XDECREF(raised_by);
  raised_by = function;
  PyObject *type, *value, *trace;
  PyErr_Fetch(&type, &value, &trace);
  PyErr_NormalizeException(&type, &value, &trace);
  if (trace) PyException_SetTraceback(value, trace);
  Py_XDECREF(type);
  Py_XDECREF(trace);
  Py_XDECREF(pending); // the last exception ended the call
  pending = value;
}

bool exception_pending()
{
  return pending != nullptr;
}

// Exceptions that end the program are raised unchanged, others as the cause of a CallbackError.
void raise_pending()
{
  PyObject *value = pending;
  pending = nullptr;
  nb::object by = raised_by ? nb::steal(raised_by) : nb::none();
  raised_by = nullptr;
  if (PyErr_GivenExceptionMatches(value, PyExc_Exception)) {
    nb::object error = make_callback_error(nb::borrow(value), by);
    PyException_SetCause(error.ptr(), value);
    PyErr_SetObject(reinterpret_cast<PyObject *>(Py_TYPE(error.ptr())), error.ptr());
  } else {
    PyErr_SetObject(reinterpret_cast<PyObject *>(Py_TYPE(value)), value);
    Py_DECREF(value);
  }
  throw nb::python_error();
}

// Two threads can be in one function, which can release the GIL: the second gets its own arrays.
call::call(callback &c) : of(c), in_use(&c.arrays), taken(!c.busy)
{
  if (taken) {
    c.busy = true;
    return;
  }
  own = make_frame(c.slots);
  in_use = &own;
}

call::~call()
{
  if (taken)
    of.busy = false;
  else
    release(own);
  if (contacts) contacts->list = nullptr; // Python may have kept them
  if (rows) rows->list = nullptr;
  if (blocks) blocks->list = nullptr;
  for (int i = 0; i < arguments; i++)
    if (is_own[i]) Py_XDECREF(argument[i]);
}

void call::put(double t)
{
  is_own[arguments] = true;
  argument[arguments++] = PyFloat_FromDouble(t);
}

template <class L> void call::hand(open_list<L> *&made, L *list)
{
  made = new open_list<L>{list, of.blocks};
  is_own[arguments] = true;
  argument[arguments++] = nb::cast(made, nb::rv_policy::take_ownership).release().ptr();
}
template void call::hand(contact_list *&made, nsdae_contact_list *list);
template void call::hand(row_list *&made, nsdae_row_list *list);
template void call::hand(block_list *&made, nsdae_block_list *list);

void call::put(const double *in)
{
  const slot &s = of.slots[static_cast<std::size_t>(used)];
  double *memory = in_use->memory[static_cast<std::size_t>(used)];
  if (in) std::memcpy(memory, in, length(s) * sizeof *memory);
  argument[arguments++] = in_use->array[static_cast<std::size_t>(used)];
  to[used++] = {nullptr, 0};
}

// The present content is copied too: zeros, or the marks of unwritten entries.
void call::put(double *out)
{
  const slot &s = of.slots[static_cast<std::size_t>(used)];
  to[used] = {out, s.rows};
  if (!of.value) argument[arguments++] = in_use->array[static_cast<std::size_t>(used)];
  double *memory = in_use->memory[static_cast<std::size_t>(used++)];
  if (out && !s.columns) std::memcpy(memory, out, length(s) * sizeof *memory);
}

// Leading dimension of the matrix before it.
void call::put(int ld)
{
  target &t = to[used - 1];
  const slot &s = of.slots[static_cast<std::size_t>(used - 1)];
  double *memory = in_use->memory[static_cast<std::size_t>(used - 1)];
  t.ld = ld;
  for (int j = 0; j < s.columns; j++)
    std::memcpy(memory + j * s.rows, t.at + j * ld,
                static_cast<std::size_t>(s.rows) * sizeof *memory);
}

void call::copy_out()
{
  for (int i = 0; i < used; i++) {
    const slot &s = of.slots[static_cast<std::size_t>(i)];
    const double *memory = in_use->memory[static_cast<std::size_t>(i)];
    for (int j = 0; to[i].at && j < std::max(s.columns, s.columns ? 0 : 1); j++)
      std::memcpy(to[i].at + j * to[i].ld, memory + j * s.rows,
                  static_cast<std::size_t>(s.rows) * sizeof *memory);
  }
}

// None: 0; an integer: the status of the callback; or the result of a callback with a value.
int call::judge(PyObject *result)
{
  if (of.value) {
    *in_use->memory[static_cast<std::size_t>(used - 1)] = PyFloat_AsDouble(result);
    return PyErr_Occurred() ? -1 : 0;
  }
  if (result == Py_None) return 0;
  if (PyLong_Check(result)) {
    int beyond = 0;
    long code = PyLong_AsLongAndOverflow(result, &beyond);
    if (!beyond && code >= INT_MIN && code <= INT_MAX) return static_cast<int>(code);
    PyErr_Format(PyExc_OverflowError,
                 "a callback returned %R: its status must be a whole number from -2^31 to 2^31 - 1",
                 result);
    return -1;
  }
  PyErr_SetString(PyExc_TypeError, "a callback writes into its last arrays and returns None, or a "
                                   "whole number: > 0 a failure that a smaller step may avoid, "
                                   "< 0 one that nothing helps");
  return -1;
}

int call::run()
{
  PyObject *result =
      PyObject_Vectorcall(of.function, argument, static_cast<std::size_t>(arguments), nullptr);
  int code = result ? judge(result) : -1;
  Py_XDECREF(result);
  if (PyErr_Occurred()) {
    remember_exception(of.function);
    return -1;
  }
  if (code == 0) copy_out();
  return code;
}

} // namespace nsdae_python
