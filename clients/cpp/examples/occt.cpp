// Fits a curve and a surface, watches the iterations, converts both to OpenCASCADE (7.6 or later),
// offsets them, checks the offsets and writes all four as STEP.
//
//     occt [URL [FILE]]        # such as http://127.0.0.1:8080 offsets.step; a token is taken from PIAD_TOKEN
//
// Copy `to_curve` and `to_surface` into your own program.

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepOffset_MakeOffset.hxx>
#include <BRep_Tool.hxx>
#include <GeomAbs_Shape.hxx>
#include <GeomConvert_ApproxCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_OffsetCurve.hxx>
#include <Geom_Surface.hxx>
#include <IFSelect_ReturnStatus.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <STEPControl_Reader.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <gp_Dir.hxx>
#include <gp_Pnt.hxx>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "piad.hpp"

namespace {

// Distinct knots and their multiplicities.
struct Knots {
    explicit Knots(const piad::Direction& direction) {
        if (direction.knots.empty()) throw std::invalid_argument("the basis " + direction.basis + " has no knots: ask for a B-spline or Bernstein basis");
        for (const double knot : direction.knots) {
            if (values.empty() || knot != values.back()) {
                values.push_back(knot);
                counts.push_back(0);
            }
            ++counts.back();
        }
    }

    TColStd_Array1OfReal distinct() const { return {values.front(), 1, static_cast<int>(values.size())}; }
    TColStd_Array1OfInteger multiplicities() const { return {counts.front(), 1, static_cast<int>(counts.size())}; }

    std::vector<double> values;
    std::vector<int> counts;
};

// The control point at this index. Plane points get z = 0.
gp_Pnt pole(const piad::Geometry& geometry, std::size_t index) {
    const std::size_t dimension = geometry.dimension();
    double xyz[3] = {0, 0, 0};
    for (std::size_t c = 0; c < (std::min)(dimension, std::size_t{3}); ++c) xyz[c] = geometry.control_points.at(index * dimension + c);
    return {xyz[0], xyz[1], xyz[2]};
}

Handle(Geom_BSplineCurve) to_curve(const piad::Geometry& geometry) {
    if (geometry.is_surface()) throw std::invalid_argument("this is a surface, not a curve");
    const int count = static_cast<int>(geometry.shape[0]);
    TColgp_Array1OfPnt poles(1, count);
    TColStd_Array1OfReal weights(1, count);
    for (int i = 1; i <= count; ++i) {
        const auto index = static_cast<std::size_t>(i - 1);
        poles.SetValue(i, pole(geometry, index));
        weights.SetValue(i, geometry.weights.empty() ? 1.0 : geometry.weights[index]);
    }
    const Knots knots(geometry.directions[0]);
    // Equal weights yield a polynomial B-spline.
    return new Geom_BSplineCurve(poles, weights, knots.distinct(), knots.multiplicities(), geometry.degree());
}

Handle(Geom_BSplineSurface) to_surface(const piad::Geometry& geometry) {
    if (!geometry.is_surface()) throw std::invalid_argument("this is a curve, not a surface");
    const int rows = static_cast<int>(geometry.shape[0]);
    const int columns = static_cast<int>(geometry.shape[1]);
    TColgp_Array2OfPnt poles(1, rows, 1, columns);
    TColStd_Array2OfReal weights(1, rows, 1, columns);
    for (int i = 1; i <= rows; ++i) {
        for (int j = 1; j <= columns; ++j) {
            const auto index = static_cast<std::size_t>((i - 1) * columns + j - 1);
            poles.SetValue(i, j, pole(geometry, index));
            weights.SetValue(i, j, geometry.weights.empty() ? 1.0 : geometry.weights[index]);
        }
    }
    const Knots u(geometry.directions[0]);
    const Knots v(geometry.directions[1]);
    return new Geom_BSplineSurface(poles, weights, u.distinct(), v.distinct(), u.multiplicities(), v.multiplicities(), geometry.degree(0), geometry.degree(1));
}

void require(bool condition, const std::string& what) {
    if (!condition) throw std::runtime_error(what);
}

// Returns the last iteration of a fit and shows progress.
piad::Iteration fitted(const piad::Client& client, const piad::Json& job) {
    piad::Iteration last;
    const auto end = client.watch(job, [&](const piad::Iteration& iteration) {
        std::cout << "  iteration " << iteration.number << ": " << iteration.error.max << "\n";
        last = iteration;
    });
    require(end && end->state == "converged", "the fit has not converged");
    return last;
}

// Sample points of a planar section.
piad::Json section() {
    piad::Json points = piad::Json::array();
    for (int i = 0; i <= 40; ++i) points.push_back({i / 4.0, std::sin(i / 8.0)});
    return {{"name", "section"}, {"curve", {{"points", points}}}, {"method", "chebyshev"}, {"stop", {{"tolerance", 1e-9}}}};
}

piad::Json saddle() {
    piad::Json rows = piad::Json::array();
    for (int i = 0; i <= 10; ++i) {
        piad::Json row = piad::Json::array();
        for (int j = 0; j <= 8; ++j) row.push_back({i - 5, j - 4, ((i - 5) * (i - 5) - (j - 4) * (j - 4)) / 20.0});
        rows.push_back(row);
    }
    return {{"name", "saddle"}, {"surface", {{"points", rows}}}, {"method", "chebyshev"}, {"stop", {{"tolerance", 1e-9}}}};
}

// The largest distance of the data from the curve at their parameters.
double error_of(const Handle(Geom_BSplineCurve) & curve, const piad::Json& points, const std::vector<double>& parameters) {
    double largest = 0;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
        const gp_Pnt point(points[i][0].get<double>(), points[i][1].get<double>(), 0);
        largest = (std::max)(largest, curve->Value(parameters[i]).Distance(point));
    }
    return largest;
}

double error_of(const Handle(Geom_BSplineSurface) & surface, const piad::Json& rows, const std::vector<double>& u, const std::vector<double>& v) {
    double largest = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
        for (std::size_t j = 0; j < v.size(); ++j) {
            const auto& row = rows[i][j];
            const gp_Pnt point(row[0].get<double>(), row[1].get<double>(), row[2].get<double>());
            largest = (std::max)(largest, surface->Value(u[i], v[j]).Distance(point));
        }
    }
    return largest;
}

double between(double low, double high, int step, int steps) { return low + (high - low) * step / steps; }

// The offset of a curve in its plane, checked to have this distance everywhere.
Handle(Geom_OffsetCurve) offset(const Handle(Geom_BSplineCurve) & curve, double distance) {
    Handle(Geom_OffsetCurve) moved = new Geom_OffsetCurve(curve, distance, gp_Dir(0, 0, 1));
    for (int i = 0; i <= 500; ++i) {
        const double t = between(curve->FirstParameter(), curve->LastParameter(), i, 500);
        require(std::abs(moved->Value(t).Distance(curve->Value(t)) - distance) < 1e-9, "the offset of the curve has another distance");
    }
    return moved;
}

// Converts it to a B-spline: OpenCASCADE silently omits offset curves from STEP.
Handle(Geom_BSplineCurve) as_bspline(const Handle(Geom_Curve) & curve, double tolerance) {
    const GeomConvert_ApproxCurve approximation(curve, tolerance, GeomAbs_C2, 1000, 8);
    require(approximation.HasResult() && approximation.MaxError() <= tolerance, "OpenCASCADE cannot approximate the offset of the curve");
    return approximation.Curve();
}

// The offset of a face, checked to be valid and at this distance everywhere, including the border.
TopoDS_Face offset(const TopoDS_Face& face, double distance) {
    BRepOffset_MakeOffset maker;
    maker.Initialize(face, distance, 1e-6, BRepOffset_Skin, Standard_False, Standard_False, GeomAbs_Arc);
    maker.MakeOffsetShape();
    require(maker.IsDone(), "OpenCASCADE cannot offset the surface");
    require(BRepCheck_Analyzer(maker.Shape()).IsValid(), "the offset of the surface is not valid");
    const TopoDS_Face moved = TopoDS::Face(TopExp_Explorer(maker.Shape(), TopAbs_FACE).Current());
    const Handle(Geom_Surface) here = BRep_Tool::Surface(face);
    const Handle(Geom_Surface) there = BRep_Tool::Surface(moved);
    double u[2];
    double v[2];
    here->Bounds(u[0], u[1], v[0], v[1]);
    for (int i = 0; i <= 30; ++i) {
        for (int j = 0; j <= 30; ++j) {
            const double s = between(u[0], u[1], i, 30);
            const double t = between(v[0], v[1], j, 30);
            require(std::abs(there->Value(s, t).Distance(here->Value(s, t)) - distance) < 1e-6, "the offset of the surface has another distance");
        }
    }
    return moved;
}

int count(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) {
    int number = 0;
    for (TopExp_Explorer explorer(shape, kind); explorer.More(); explorer.Next()) ++number;
    return number;
}

// Writes all shapes to one file and reads it back.
void write_step(const std::string& file, const std::vector<TopoDS_Shape>& shapes) {
    STEPControl_Writer writer;
    for (const auto& shape : shapes) require(writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone, "OpenCASCADE cannot translate to STEP");
    require(writer.Write(file.c_str()) == IFSelect_RetDone, "OpenCASCADE cannot write " + file);
    STEPControl_Reader reader;
    require(reader.ReadFile(file.c_str()) == IFSelect_RetDone, "OpenCASCADE cannot read what it has written");
    reader.TransferRoots();
    require(count(reader.OneShape(), TopAbs_FACE) == 2, "the file has another number of faces");
    // Each face has four edges.
    require(count(reader.OneShape(), TopAbs_EDGE) == 2 + 2 * 4, "the file has another number of edges");
}

void run(const std::string& url, const std::string& file) {
    piad::ClientOptions options;
    if (const char* token = std::getenv("PIAD_TOKEN")) options.token = token;
    const piad::Client client(url, options);

    std::cout << "curve\n";
    const auto section_job = section();
    const auto section_fit = fitted(client, section_job);
    const auto curve = to_curve(section_fit);
    const double curve_error = error_of(curve, section_job["curve"]["points"], section_fit.directions[0].parameters);
    require(curve_error < 2e-9, "the curve of OpenCASCADE is not that of the fit");

    std::cout << "surface\n";
    const auto saddle_job = saddle();
    const auto saddle_fit = fitted(client, saddle_job);
    const auto surface = to_surface(saddle_fit);
    const double surface_error =
        error_of(surface, saddle_job["surface"]["points"], saddle_fit.directions[0].parameters, saddle_fit.directions[1].parameters);
    require(surface_error < 2e-9, "the surface of OpenCASCADE is not that of the fit");

    const TopoDS_Face face = BRepBuilderAPI_MakeFace(surface, 1e-7).Face();
    const auto parallel_curve = as_bspline(offset(curve, 0.2), 1e-6);
    const auto parallel_face = offset(face, 0.1);
    write_step(file, {BRepBuilderAPI_MakeEdge(curve).Shape(), BRepBuilderAPI_MakeEdge(parallel_curve).Shape(), face, parallel_face});
    std::cout << "errors in OpenCASCADE: " << curve_error << ", " << surface_error << "; offsets checked; wrote " << file << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        // Silences the messages of OpenCASCADE.
        Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
        run(argc > 1 ? argv[1] : "http://127.0.0.1:8080", argc > 2 ? argv[2] : "offsets.step");
        return 0;
    } catch (const Standard_Failure& error) {
        std::cerr << "occt: " << error.GetMessageString() << std::endl;
    } catch (const std::exception& error) {
        std::cerr << "occt: " << error.what() << std::endl;
    }
    return 1;
}
