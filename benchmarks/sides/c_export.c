/* The exported C of the forging robot behind the same door as floor.c: `one(u, du, ddu, out)`.
   No passive angles are asked for, as from the other sides. */
#define PY_SSIZE_T_CLEAN
#define NPY_NO_DEPRECATED_API NPY_1_7_API_VERSION
#include "forging_chu2020.h"
#include <Python.h>
#include <numpy/arrayobject.h>

static int usable(PyObject *o) {
  PyArrayObject *a = (PyArrayObject *)o;
  return PyArray_CheckExact(o) && PyArray_TYPE(a) == NPY_DOUBLE && PyArray_NDIM(a) == 1 && PyArray_DIM(a, 0) == 4 &&
         PyArray_ISCARRAY_RO(a);
}

static PyObject *one(PyObject *self, PyObject *const *args, Py_ssize_t n) {
  if (n < 3 || n > 4) return PyErr_Format(PyExc_TypeError, "u, du, ddu, out");
  for (Py_ssize_t k = 0; k < n; k++)
    if (!usable(args[k])) return PyErr_Format(PyExc_ValueError, "expected arrays (4,)");
  const double *u = PyArray_DATA((PyArrayObject *)args[0]), *du = PyArray_DATA((PyArrayObject *)args[1]),
               *dd = PyArray_DATA((PyArrayObject *)args[2]);
  npy_intp four = 4;
  PyObject *out = n == 4 ? Py_NewRef(args[3]) : PyArray_SimpleNew(1, &four, NPY_DOUBLE);
  if (!out) return NULL;
  double *tau = PyArray_DATA((PyArrayObject *)out);
  int status = forging_chu2020_inverse_dynamics(u, du, dd, forging_chu2020_gravity, NULL, tau);
  if (status) {
    Py_DECREF(out);
    return PyErr_Format(PyExc_ArithmeticError, "%s", forging_chu2020_status_text(status));
  }
  return out;
}

static PyMethodDef methods[] = {{"one", (PyCFunction)(void *)one, METH_FASTCALL, NULL}, {NULL, NULL, 0, NULL}};
static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "c_export", NULL, -1, methods};

PyMODINIT_FUNC PyInit_c_export(void) {
  import_array();
  return PyModule_Create(&module);
}
