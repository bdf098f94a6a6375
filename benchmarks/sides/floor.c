/* The forging robot by hand: closure and inverse dynamics in minimal form, for one state and for a batch.

   Everything but the yaw q1 and the roll q4 happens in one vertical plane: x outward from the column, y up. Links of the
   arm have their mass at  k + a e2 + b e3  with e2 = (cos q2, sin q2) along the upper arm and e3 along the forearm
   (turned by q2 + q3), so that only sums over links enter, made once by `setup`. Link i also has an inertia about the
   normal of the plane and, where it turns with e2 or e3, unequal moments in the plane. Cylinders are treated one by one:
   barrel and rod on the direction from pivot to pin. The gripper's axis stays level and its other moments are equal. */
#define PY_SSIZE_T_CLEAN
#define NPY_NO_DEPRECATED_API NPY_1_7_API_VERSION
#include <Python.h>
#include <math.h>
#include <numpy/arrayobject.h>

#define ALWAYS_INLINE inline __attribute__((always_inline)) /* otherwise the loop over states is not vectorized */

typedef struct {
  double g, base1, arm1, first1, base2, arm2, first2; /* triangles; length of a cylinder at zero stroke */
  double ka, kb, kxx, aa, ab, bb, kxa, kxb;           /* sums over the arm: m a, m b, m kx^2, m a^2, m a b, ... */
  double i2, i3, d2, d3, column, roll;                /* Izz, Ixx - Iyy of links along e2 and e3; what only yaws, rolls */
  double mb1, cb1, mr1, cr1, izz1, diff1;             /* barrel and rod of cylinder 1: masses, places; Izz, Ixx - Iyy */
  double mb2, cb2, mr2, cr2, izz2, diff2;
  double p1, p2;                                      /* pivot of cylinder 1 (x), of cylinder 2 (along the upper arm) */
} Robot;

static Robot R;

/* One cylinder: forces of barrel and rod for an acceleration of its pivot and of its tilt. */
typedef struct { double fx, fy, moment, along, yaw, yawdot; } Cylinder;

static ALWAYS_INLINE Cylinder cylinder(double x0, double vx, double ax, double ay, double c, double s, double w, double dw,
                                double l, double v, double a, double o2, double mb, double cb, double mr, double cr,
                                double izz, double diff) {
  /* pivot at x0 with velocity vx (outward) and acceleration (ax, ay - g); direction (c, s), rate w; length l, v, a */
  double r = l + cr;
  double xb = x0 + cb * c, xr = x0 + r * c;
  double bx = ax - cb * (dw * s + w * w * c) - xb * o2, by = ay + cb * (dw * c - w * w * s);
  double rx = ax + a * c - 2.0 * v * w * s - r * (dw * s + w * w * c) - xr * o2;
  double ry = ay + a * s + 2.0 * v * w * c + r * (dw * c - w * w * s);
  double vb = vx - cb * w * s, vr = vx + v * c - r * w * s;
  Cylinder k;
  k.fx = mb * bx + mr * rx;
  k.fy = mb * by + mr * ry;
  k.moment = mb * cb * (by * c - bx * s) + mr * r * (ry * c - rx * s) + izz * dw - diff * s * c * o2;
  k.along = mr * (rx * c + ry * s);
  k.yaw = mb * xb * xb + mr * xr * xr + diff * s * s;
  k.yawdot = 2.0 * (mb * xb * vb + mr * xr * vr + diff * s * c * w);
  return k;
}

static ALWAYS_INLINE void inverse_dynamics(double q12, double q22, double v1, double v12, double v22, double a1, double a12,
                                    double a22, double *restrict tau1, double *restrict tau12, double *restrict tau22) {
  /* triangles: length^2 = base^2 + arm^2 + 2 base arm cos(angle) */
  double l1 = R.first1 + q12, l2 = R.first2 + q22, k1 = R.base1 * R.arm1, k2 = R.base2 * R.arm2;
  double c1 = (l1 * l1 - R.base1 * R.base1 - R.arm1 * R.arm1) / (2.0 * k1), s1 = sqrt(1.0 - c1 * c1);
  double c2 = (l2 * l2 - R.base2 * R.base2 - R.arm2 * R.arm2) / (2.0 * k2), s2 = sqrt(1.0 - c2 * c2);
  double t1 = -l1 / (k1 * s1), t2 = -l2 / (k2 * s2); /* angle by length */
  double w2 = t1 * v12, wr = t2 * v22;
  double dw2 = t1 * a12 - (v12 * v12 + k1 * c1 * w2 * w2) / (k1 * s1);
  double dwr = t2 * a22 - (v22 * v22 + k2 * c2 * wr * wr) / (k2 * s2);
  /* tilts of the cylinders against their bases */
  double i1 = 1.0 / l1, i2 = 1.0 / l2;
  double e1c = (R.base1 + R.arm1 * c1) * i1, e1s = R.arm1 * s1 * i1;
  double e2c = (R.base2 + R.arm2 * c2) * i2, e2s = R.arm2 * s2 * i2;
  /* rate of a tilt: across component of the pin's velocity over the length; then its derivative */
  double n1c = c1 * e1c + s1 * e1s, n1s = s1 * e1c - c1 * e1s, n2c = c2 * e2c + s2 * e2s, n2s = s2 * e2c - c2 * e2s;
  double w11 = R.arm1 * w2 * n1c * i1, w21 = R.arm2 * wr * n2c * i2;
  double dw11 = (R.arm1 * (dw2 * n1c - w2 * w2 * n1s) - 2.0 * v12 * w11) * i1;
  double dw21 = (R.arm2 * (dwr * n2c - wr * wr * n2s) - 2.0 * v22 * w21) * i2;
  double u1 = R.arm1 * n1c * i1 * t1, u2 = R.arm2 * n2c * i2 * t2; /* tilt by length */

  /* arm: e2 at q2, e3 at q2 + q3 with q3 = angle - pi */
  double ce = c1, se = s1, cf = -(c1 * c2 - s1 * s2), sf = -(s1 * c2 + c1 * s2);
  double w3 = w2 + wr, dw3 = dw2 + dwr, o2 = v1 * v1, g = R.g;
  double cd = ce * cf + se * sf, sd = ce * sf - se * cf; /* e3 against e2 */
  double xa = R.kxa + R.aa * ce + R.ab * cf, xb = R.kxb + R.ab * ce + R.bb * cf; /* sums of m a x, m b x */
  double q2 = (R.aa + R.i2) * dw2 + R.ab * (dw3 * cd - w3 * w3 * sd) + xa * se * o2 + R.ka * ce * g - R.d2 * se * ce * o2;
  double q3 = (R.bb + R.i3) * dw3 + R.ab * (dw2 * cd + w2 * w2 * sd) + xb * sf * o2 + R.kb * cf * g - R.d3 * sf * cf * o2;
  double inertia = R.column + R.kxx + 2.0 * (R.kxa * ce + R.kxb * cf + R.ab * ce * cf) + R.aa * ce * ce + R.bb * cf * cf +
                   R.d2 * se * se + R.d3 * sf * sf;
  double change = -2.0 * (xa * se * w2 + xb * sf * w3) + 2.0 * (R.d2 * se * ce * w2 + R.d3 * sf * cf * w3);

  Cylinder a = cylinder(R.p1, 0.0, 0.0, g, e1c, e1s, w11, dw11, l1, v12, a12, o2, R.mb1, R.cb1, R.mr1, R.cr1,
                        R.izz1, R.diff1);
  double bc = ce * e2c - se * e2s, bs = se * e2c + ce * e2s; /* cylinder 2 on the upper arm */
  double px = R.p2 * ce;
  Cylinder b = cylinder(px, -R.p2 * se * w2, -R.p2 * (dw2 * se + w2 * w2 * ce),
                        R.p2 * (dw2 * ce - w2 * w2 * se) + g, bc, bs, w2 + w21, dw2 + dw21, l2, v22, a22, o2, R.mb2,
                        R.cb2, R.mr2, R.cr2, R.izz2, R.diff2);
  double upper = q2 + q3 + b.moment + R.p2 * (b.fy * ce - b.fx * se);
  *tau1 = (inertia + a.yaw + b.yaw) * a1 + (change + a.yawdot + b.yawdot) * v1;
  *tau12 = t1 * upper + u1 * a.moment + a.along;
  *tau22 = t2 * q3 + u2 * b.moment + b.along;
}

static int usable(PyObject *o, int rank) {
  PyArrayObject *a = (PyArrayObject *)o;
  return PyArray_CheckExact(o) && PyArray_TYPE(a) == NPY_DOUBLE && PyArray_NDIM(a) == rank &&
         PyArray_DIM(a, rank - 1) == 4 && PyArray_ISCARRAY_RO(a);
}

static PyObject *one(PyObject *self, PyObject *const *args, Py_ssize_t n) {
  if (n < 3 || n > 4) return PyErr_Format(PyExc_TypeError, "u, du, ddu, out");
  for (Py_ssize_t k = 0; k < n; k++)
    if (!usable(args[k], 1)) return PyErr_Format(PyExc_ValueError, "expected arrays (4,)");
  const double *u = PyArray_DATA((PyArrayObject *)args[0]), *du = PyArray_DATA((PyArrayObject *)args[1]),
               *dd = PyArray_DATA((PyArrayObject *)args[2]);
  npy_intp four = 4;
  PyObject *out = n == 4 ? Py_NewRef(args[3]) : PyArray_SimpleNew(1, &four, NPY_DOUBLE);
  if (!out) return NULL;
  double *tau = PyArray_DATA((PyArrayObject *)out);
  inverse_dynamics(u[1], u[2], du[0], du[1], du[2], dd[0], dd[1], dd[2], tau, tau + 1, tau + 2);
  tau[3] = R.roll * dd[3];
  if (!isfinite(tau[0] + tau[1] + tau[2] + tau[3])) {
    Py_DECREF(out);
    return PyErr_Format(PyExc_ArithmeticError, "does not close");
  }
  return out;
}

#define BLOCK 64

static void block(const double *restrict u, const double *restrict du, const double *restrict dd, double *restrict out) {
  double a[4][BLOCK], b[4][BLOCK], c[4][BLOCK], tau[4][BLOCK];
  for (int i = 0; i < BLOCK; i++)
    for (int j = 0; j < 4; j++) a[j][i] = u[4 * i + j], b[j][i] = du[4 * i + j], c[j][i] = dd[4 * i + j];
#pragma omp simd
  for (int i = 0; i < BLOCK; i++) {
    double t1, t12, t22;
    inverse_dynamics(a[1][i], a[2][i], b[0][i], b[1][i], b[2][i], c[0][i], c[1][i], c[2][i], &t1, &t12, &t22);
    tau[0][i] = t1, tau[1][i] = t12, tau[2][i] = t22, tau[3][i] = R.roll * c[3][i];
  }
  for (int i = 0; i < BLOCK; i++)
    for (int j = 0; j < 4; j++) out[4 * i + j] = tau[j][i];
}

static void last_block(const double *u, const double *du, const double *dd, double *out, npy_intp rows) {
  double a[4 * BLOCK], b[4 * BLOCK], c[4 * BLOCK], o[4 * BLOCK];
  for (int i = 0; i < 4 * BLOCK; i++) {
    npy_intp k = i < 4 * rows ? i : i % 4;
    a[i] = u[k], b[i] = du[k], c[i] = dd[k];
  }
  block(a, b, c, o);
  for (int i = 0; i < 4 * rows; i++) out[i] = o[i];
}

static PyObject *batch(PyObject *self, PyObject *const *args, Py_ssize_t n) {
  if (n != 3) return PyErr_Format(PyExc_TypeError, "u, du, ddu");
  for (Py_ssize_t k = 0; k < n; k++)
    if (!usable(args[k], 2)) return PyErr_Format(PyExc_ValueError, "expected arrays (N, 4)");
  PyArrayObject *u = (PyArrayObject *)args[0], *du = (PyArrayObject *)args[1], *dd = (PyArrayObject *)args[2];
  npy_intp rows = PyArray_DIM(u, 0);
  if (PyArray_DIM(du, 0) != rows || PyArray_DIM(dd, 0) != rows) return PyErr_Format(PyExc_ValueError, "lengths differ");
  PyObject *out = PyArray_SimpleNew(2, PyArray_DIMS(u), NPY_DOUBLE);
  if (!out) return NULL;
  const double *a = PyArray_DATA(u), *b = PyArray_DATA(du), *c = PyArray_DATA(dd);
  double *o = PyArray_DATA((PyArrayObject *)out);
  npy_intp i = 0;
  for (; i + BLOCK <= rows; i += BLOCK) block(a + 4 * i, b + 4 * i, c + 4 * i, o + 4 * i);
  if (i < rows) last_block(a + 4 * i, b + 4 * i, c + 4 * i, o + 4 * i, rows - i);
  return out;
}

static PyObject *setup(PyObject *self, PyObject *const *args, Py_ssize_t n) {
  const Py_ssize_t size = sizeof(R) / sizeof(double);
  if (n != size) return PyErr_Format(PyExc_ValueError, "expected %zd numbers", size);
  for (Py_ssize_t k = 0; k < n; k++) ((double *)&R)[k] = PyFloat_AsDouble(args[k]);
  return PyErr_Occurred() ? NULL : Py_NewRef(Py_None);
}

static PyMethodDef methods[] = {{"setup", (PyCFunction)(void *)setup, METH_FASTCALL, NULL},
                                {"one", (PyCFunction)(void *)one, METH_FASTCALL, NULL},
                                {"batch", (PyCFunction)(void *)batch, METH_FASTCALL, NULL},
                                {NULL, NULL, 0, NULL}};
static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "floor", NULL, -1, methods};

PyMODINIT_FUNC PyInit_floor(void) {
  import_array();
  return PyModule_Create(&module);
}
