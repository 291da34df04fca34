/* fix wall/heightmap: a rigid wall of any heights and any law above a surface, as a plugin of LAMMPS.

   Syntax

     plugin load heightmap.so
     fix ID group wall/heightmap FILE separation D keyword values ...

     FILE        heights of the wall over the period of the box, and the law (see below)
     separation  D of the plane h = 0 of the wall above z = surface: a number, or v_name of a variable
     offset      X Y of the wall: numbers, or v_name of variables; 0 0 by default
     surface     z of the surface from which the separation counts; 0 by default
     units       L E: units of length and energy of FILE and of the keywords in those of LAMMPS; 1 1 by default
     site        d_name: the height above each atom is this property of it, and does not change as it moves sideways;
                 without this keyword it is that of the map above where the atom is

   An atom at (x, y, z) has the energy w(gap) at gap = D + h(x - X, y - Y) - (z - surface), and the force on it is the
   gradient of that: with the traction p = -dw/dgap it is -p along z, and p dh/dx, p dh/dy along x and y.

   Between its points, which stand equally far apart over the period, from the lower corner of the box on, the map is a
   periodic bicubic spline: heights have continuous curvatures.  The law is made of cubic pieces of the traction; below
   the first it goes on with constant stiffness, beyond the last there is none.

   FILE, in text: "map NX NY" and NX x NY heights, those along y first; "law N GAP ENERGY", the end of the last piece and
   the energy beyond it, and N lines "gap energy a0 a1 a2 a3" of pieces: where each begins, its energy there, and the
   traction a0 + a1 s + a2 s^2 + a3 s^3 at s = gap - beginning.  Lines that begin with # are comments.

   Output: a global scalar, the energy (fix_modify energy yes adds it to that of the system); a global vector, the force
   on the atoms along x, y and z; a per-atom array: gap, traction, energy, height, and slopes of the wall along x and y,
   in the units of FILE, then the gap and the force along z in those of LAMMPS, as are scalar and vector.  fix_modify
   virial yes adds the virial to pressure and stress: of an atom and the wall above it, the gap apart along z, so that
   z z is -gap f_z, x z is -gap f_x, y z is -gap f_y, and the others, which move wall and atom alike, are zero.  It acts
   in runs and in minimisations, not in rRESPA.  Nothing is written to restarts.  fix_wall_heightmap.rst says more. */

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "input.h"
#include "lammps.h"
#include "memory.h"
#include "update.h"
#include "utils.h"
#include "variable.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

struct Piece {
  double gap, energy, a0, a1, a2, a3;
};

/* A number, or the name of a variable. */
struct Quantity {
  std::string name;
  double value = 0.0;
};

/* Coefficients of the periodic cubic B-spline through n values, a stride apart: the recursive filter of Unser. */
void prefilter(double *values, int n, int stride)
{
  const double z = std::sqrt(3.0) - 2.0;
  if (n == 1) return;
  std::vector<double> up(n);
  const double period = 1.0 / (1.0 - std::pow(z, n));
  double sum = 0.0, power = 1.0;
  for (int k = 0; k < n; k++, power *= z) sum += power * values[((n - k) % n) * stride];
  up[0] = sum * period;
  for (int i = 1; i < n; i++) up[i] = values[i * stride] + z * up[i - 1];
  sum = 0.0;
  power = 1.0;
  for (int k = 0; k < n; k++, power *= z) sum += power * up[(n - 1 + k) % n];
  double above = -z * sum * period;
  values[(n - 1) * stride] = 6.0 * above;
  for (int i = n - 2; i >= 0; i--) {
    above = z * (above - up[i]);
    values[i * stride] = 6.0 * above;
  }
}

/* The four cubic B-splines that are not zero at a fraction t of a spacing, and their derivatives. */
void weights(double t, double *w, double *d)
{
  const double s = 1.0 - t;
  w[0] = s * s * s / 6.0;
  w[1] = (t * t * (3.0 * t - 6.0) + 4.0) / 6.0;
  w[2] = (s * s * (3.0 * s - 6.0) + 4.0) / 6.0;
  w[3] = t * t * t / 6.0;
  d[0] = -0.5 * s * s;
  d[1] = 0.5 * t * (3.0 * t - 4.0);
  d[2] = -0.5 * s * (3.0 * s - 4.0);
  d[3] = 0.5 * t * t;
}

constexpr int COLUMNS = 8;    // of the per-atom array

class FixWallHeightmap : public Fix {
 public:
  FixWallHeightmap(LAMMPS *, int, char **);
  ~FixWallHeightmap() override { memory->destroy(array_atom); }
  int setmask() override { return POST_FORCE | MIN_POST_FORCE; }
  void init() override;
  void setup(int vflag) override { post_force(vflag); }
  void min_setup(int vflag) override { post_force(vflag); }
  void min_post_force(int vflag) override { post_force(vflag); }
  void post_force(int) override;
  double compute_scalar() override { return all()[3]; }
  double compute_vector(int i) override { return all()[i]; }
  double memory_usage() override { return 8.0 * (1.0 * COLUMNS * nmax + coefficients.size()); }

 private:
  int nx = 0, ny = 0, nmax = 0;
  std::vector<double> coefficients;    // of the map, those along y first
  std::vector<Piece> pieces;
  double end = 0.0, beyond = 0.0;    // of the law: its last gap, and the energy beyond
  Quantity separation, offset[2], surface;
  double length = 1.0, energy = 1.0;
  std::string site;
  double mine[4], summed[4];    // forces along x, y and z, and energy
  bool is_summed = false;

  void read(const std::string &);
  Quantity quantity(const char *);
  double now(const Quantity &);
  void map(double, double, double *) const;
  void law(double, double *) const;
  const double *all();
};

FixWallHeightmap::FixWallHeightmap(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg < 6 || strcmp(arg[4], "separation") != 0)
    error->all(FLERR, "fix wall/heightmap needs a file and a separation");
  separation = quantity(arg[5]);
  auto left = [&](int i, int count) {
    if (i + count >= narg) error->all(FLERR, std::string("fix wall/heightmap: values of ") + arg[i] + " are missing");
  };
  for (int i = 6; i < narg;) {
    const std::string keyword = arg[i];
    if (keyword == "offset") {
      left(i, 2);
      for (int axis = 0; axis < 2; axis++) offset[axis] = quantity(arg[i + 1 + axis]);
      i += 3;
    } else if (keyword == "surface") {
      left(i, 1);
      surface = quantity(arg[i + 1]);
      i += 2;
    } else if (keyword == "units") {
      left(i, 2);
      length = utils::numeric(FLERR, arg[i + 1], false, lmp);
      energy = utils::numeric(FLERR, arg[i + 2], false, lmp);
      i += 3;
    } else if (keyword == "site") {
      left(i, 1);
      if (strncmp(arg[i + 1], "d_", 2) != 0) error->all(FLERR, "fix wall/heightmap: a site is a property d_name");
      site = arg[i + 1] + 2;
      i += 2;
    } else
      error->all(FLERR, "fix wall/heightmap: unknown keyword " + keyword);
  }
  if (!(length > 0.0 && energy > 0.0)) error->all(FLERR, "fix wall/heightmap: units are positive");
  if (domain->triclinic || !domain->xperiodic || !domain->yperiodic)
    error->all(FLERR, "fix wall/heightmap needs a rectangular box that is periodic along x and y");
  read(arg[3]);
  scalar_flag = vector_flag = peratom_flag = 1;
  size_vector = 3;
  extscalar = extvector = 1;
  global_freq = peratom_freq = 1;
  size_peratom_cols = COLUMNS;
  energy_global_flag = virial_global_flag = virial_peratom_flag = 1;
  memory->create(array_atom, nmax = std::max(atom->nmax, 1), COLUMNS, "wall/heightmap:array_atom");
  memset(&array_atom[0][0], 0, sizeof(double) * COLUMNS * nmax);
  memset(mine, 0, sizeof(mine));
}

Quantity FixWallHeightmap::quantity(const char *text)
{
  if (strncmp(text, "v_", 2) == 0) return {text + 2, 0.0};
  return {"", utils::numeric(FLERR, text, false, lmp)};
}

double FixWallHeightmap::now(const Quantity &q)
{
  if (q.name.empty()) return q.value;
  if (input->variable->find(q.name.c_str()) < 0)
    error->all(FLERR, "fix wall/heightmap: there is no variable " + q.name);
  return input->variable->compute_equal("v_" + q.name);    // index-style variables, too
}

void FixWallHeightmap::read(const std::string &name)
{
  std::string text;
  if (comm->me == 0) {
    std::ifstream file(name);
    if (!file) error->one(FLERR, "fix wall/heightmap cannot open " + name);
    for (std::string line; std::getline(file, line);)
      if (line.empty() || line[0] != '#') text += line + '\n';
  }
  int size = text.size();
  MPI_Bcast(&size, 1, MPI_INT, 0, world);
  text.resize(size);
  MPI_Bcast(&text[0], size, MPI_CHAR, 0, world);
  std::istringstream words(text);
  std::string word;
  int count = 0;
  if (!(words >> word >> nx >> ny) || word != "map" || nx < 1 || ny < 1)
    error->all(FLERR, name + " does not begin with a map");
  coefficients.resize(static_cast<size_t>(nx) * ny);
  for (auto &height : coefficients) words >> height;
  if (!(words >> word >> count >> end >> beyond) || word != "law" || count < 1)
    error->all(FLERR, name + " does not go on with a law");
  pieces.resize(count);
  for (auto &p : pieces) words >> p.gap >> p.energy >> p.a0 >> p.a1 >> p.a2 >> p.a3;
  if (!words) error->all(FLERR, name + " ends before its law does");
  for (int i = 0; i < nx; i++) prefilter(&coefficients[static_cast<size_t>(i) * ny], ny, 1);
  for (int j = 0; j < ny; j++) prefilter(&coefficients[j], nx, ny);
}

void FixWallHeightmap::init()
{
  if (utils::strmatch(update->integrate_style, "^respa")) error->all(FLERR, "fix wall/heightmap knows no rRESPA");
  int is_double, columns;
  if (!site.empty() && (atom->find_custom(site.c_str(), is_double, columns) < 0 || !is_double || columns))
    error->all(FLERR, "fix wall/heightmap: there is no property d_" + site);
}

/* Height and slopes of the map above a point, which is given in spacings of its points. */
void FixWallHeightmap::map(double u, double v, double *found) const
{
  const double fu = std::floor(u), fv = std::floor(v);
  double wu[4], du[4], wv[4], dv[4];
  weights(u - fu, wu, du);
  weights(v - fv, wv, dv);
  const int i = static_cast<int>(fu), j = static_cast<int>(fv);
  int column[4];
  for (int b = 0; b < 4; b++) column[b] = (((j - 1 + b) % ny) + ny) % ny;
  found[0] = found[1] = found[2] = 0.0;
  for (int a = 0; a < 4; a++) {
    const double *row = &coefficients[static_cast<size_t>((((i - 1 + a) % nx) + nx) % nx) * ny];
    double along = 0.0, slope = 0.0;
    for (int b = 0; b < 4; b++) {
      along += wv[b] * row[column[b]];
      slope += dv[b] * row[column[b]];
    }
    found[0] += wu[a] * along;
    found[1] += du[a] * along;
    found[2] += wu[a] * slope;
  }
}

/* Traction and energy at a gap. */
void FixWallHeightmap::law(double gap, double *found) const
{
  if (gap >= end) {
    found[0] = 0.0;
    found[1] = beyond;
    return;
  }
  const Piece &first = pieces.front();
  if (gap < first.gap) {
    const double s = gap - first.gap;
    found[0] = first.a0 + first.a1 * s;
    found[1] = first.energy - s * (first.a0 + 0.5 * first.a1 * s);
    return;
  }
  const auto above = std::upper_bound(pieces.begin(), pieces.end(), gap,
                                      [](double value, const Piece &p) { return value < p.gap; });
  const Piece &p = *(above - 1);
  const double s = gap - p.gap;
  found[0] = p.a0 + s * (p.a1 + s * (p.a2 + s * p.a3));
  found[1] = p.energy - s * (p.a0 + s * (p.a1 / 2.0 + s * (p.a2 / 3.0 + s * p.a3 / 4.0)));
}

void FixWallHeightmap::post_force(int vflag)
{
  v_init(vflag);
  if (atom->nmax > nmax) {
    memory->destroy(array_atom);
    memory->create(array_atom, nmax = atom->nmax, COLUMNS, "wall/heightmap:array_atom");
    memset(&array_atom[0][0], 0, sizeof(double) * COLUMNS * nmax);
  }
  int is_double, columns;
  const double *heights = nullptr;
  if (!site.empty()) heights = atom->dvector[atom->find_custom(site.c_str(), is_double, columns)];
  const double level = now(separation) + now(surface), shift[2] = {now(offset[0]), now(offset[1])};
  const double per_x = nx / domain->prd[0], per_y = ny / domain->prd[1];    // spacings per unit of length
  const double force = energy / length;
  double **x = atom->x, **f = atom->f;
  const int *mask = atom->mask;
  memset(mine, 0, sizeof(mine));
  for (int i = 0; i < atom->nlocal; i++) {
    double *out = array_atom[i];
    if (!(mask[i] & groupbit)) {
      memset(out, 0, COLUMNS * sizeof(double));
      continue;
    }
    double above[3] = {0.0, 0.0, 0.0}, acts[2];
    if (heights)
      above[0] = heights[i];
    else {
      map((x[i][0] - domain->boxlo[0] - shift[0] * length) * per_x,
          (x[i][1] - domain->boxlo[1] - shift[1] * length) * per_y, above);
      above[1] *= per_x * length;
      above[2] *= per_y * length;
    }
    const double gap = level + above[0] - x[i][2] / length;
    law(gap, acts);
    const double on[3] = {acts[0] * above[1] * force, acts[0] * above[2] * force, -acts[0] * force};
    for (int k = 0; k < 3; k++) {
      f[i][k] += on[k];
      mine[k] += on[k];
    }
    mine[3] += acts[1] * energy;
    if (evflag) {
      const double apart = gap * length;
      double virial[6] = {0.0, 0.0, -apart * on[2], 0.0, -apart * on[0], -apart * on[1]};
      v_tally(i, virial);
    }
    out[0] = gap;
    out[1] = acts[0];
    out[2] = acts[1];
    for (int k = 0; k < 3; k++) out[3 + k] = above[k];
    out[6] = gap * length;
    out[7] = on[2];
  }
  is_summed = false;
}

const double *FixWallHeightmap::all()
{
  if (!is_summed) MPI_Allreduce(mine, summed, 4, MPI_DOUBLE, MPI_SUM, world);
  is_summed = true;
  return summed;
}

Fix *create(LAMMPS *lmp, int narg, char **arg) { return new FixWallHeightmap(lmp, narg, arg); }

/* What LAMMPS is told of a plugin: as in its lammpsplugin.h, which an installed LAMMPS comes without. */
struct Plugin {
  const char *version, *style, *name, *info, *author;
  Fix *(*creator)(LAMMPS *, int, char **);
  void *handle;
};

}    // namespace

/* Sizes of the integers of LAMMPS, where its library says them. */
extern "C" int lammps_extract_setting(void *, const char *) __attribute__((weak));

extern "C" void lammpsplugin_init(void *lmp, void *handle, void *regfunc)
{
  LAMMPS *here = static_cast<LAMMPS *>(lmp);
#ifdef BUILT_FOR
  if (here->num_ver != BUILT_FOR)
    here->error->all(FLERR, "heightmap.so was built for LAMMPS {}, and this is {}: build it anew, as README.txt says",
                     BUILT_FOR, here->num_ver);
#endif
  if (lammps_extract_setting && lammps_extract_setting(lmp, "tagint") != (int) sizeof(tagint))
    here->error->all(FLERR, "heightmap.so was built for atom numbers of {} bytes, and this LAMMPS has {}: build it anew "
                     "with -DLAMMPS_BIGBIG or -DLAMMPS_SMALLBIG, as it was", sizeof(tagint),
                     lammps_extract_setting(lmp, "tagint"));
  Plugin plugin = {here->version, "fix", "wall/heightmap",
                   "rigid wall of any heights and any law", "stickiness", &create, handle};
  reinterpret_cast<void (*)(Plugin *, void *)>(regfunc)(&plugin, lmp);
}
