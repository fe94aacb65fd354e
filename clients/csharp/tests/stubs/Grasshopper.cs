// Stubs: signatures of Grasshopper 1 that the example calls. A document solves its component
// immediately.

using System;
using System.Collections.Generic;

namespace Grasshopper.Kernel
{
    public enum GH_ParamAccess { item, list, tree }

    public enum GH_RuntimeMessageLevel { Blank, Warning, Error, Remark }

    public enum GH_DocumentContext { None, Loaded, Unloaded, Open, Close, Lock, Unlock }

    public interface IGH_Param
    {
        bool Optional { get; set; }
    }

    public interface IGH_DataAccess
    {
        int Iteration { get; }
        bool GetData<T>(int index, ref T destination);
        bool GetDataList<T>(int index, List<T> list);
        bool SetData(int paramIndex, object data);
    }

    public class GH_Document
    {
        public delegate void GH_ScheduleDelegate(GH_Document doc);

        public void ScheduleSolution(int delay, GH_ScheduleDelegate callback) { callback(this); }
    }

    public abstract class GH_Component
    {
        public sealed class GH_InputParamManager
        {
            private readonly List<IGH_Param> parameters = new List<IGH_Param>();

            public IGH_Param this[int index] { get { return parameters[index]; } }

            public int AddPointParameter(string name, string nickname, string description, GH_ParamAccess access) { return Add(); }
            public int AddIntegerParameter(string name, string nickname, string description, GH_ParamAccess access, int @default) { return Add(); }
            public int AddNumberParameter(string name, string nickname, string description, GH_ParamAccess access, double @default) { return Add(); }
            public int AddBooleanParameter(string name, string nickname, string description, GH_ParamAccess access, bool @default) { return Add(); }
            public int AddTextParameter(string name, string nickname, string description, GH_ParamAccess access) { return Add(); }
            public int AddTextParameter(string name, string nickname, string description, GH_ParamAccess access, string @default) { return Add(); }

            private int Add()
            {
                parameters.Add(new Parameter());
                return parameters.Count - 1;
            }

            private sealed class Parameter : IGH_Param
            {
                public bool Optional { get; set; }
            }
        }

        public sealed class GH_OutputParamManager
        {
            public int AddCurveParameter(string name, string nickname, string description, GH_ParamAccess access) { return 0; }
            public int AddIntegerParameter(string name, string nickname, string description, GH_ParamAccess access) { return 0; }
            public int AddNumberParameter(string name, string nickname, string description, GH_ParamAccess access) { return 0; }
            public int AddTextParameter(string name, string nickname, string description, GH_ParamAccess access) { return 0; }
        }

        private readonly GH_Document document = new GH_Document();

        protected GH_Component(string name, string nickname, string description, string category, string subCategory) { }

        // Only in the stub, for the tests.
        public event Action Expired;
        public readonly List<string> Messages = new List<string>();

        public abstract Guid ComponentGuid { get; }
        public string Message { get; set; }

        public GH_Document OnPingDocument() { return document; }

        public virtual void ExpireSolution(bool recompute)
        {
            if (Expired != null) Expired();
        }

        public virtual void RemovedFromDocument(GH_Document document) { }
        public virtual void DocumentContextChanged(GH_Document document, GH_DocumentContext context) { }
        public void AddRuntimeMessage(GH_RuntimeMessageLevel level, string text) { Messages.Add(level + ": " + text); }

        // Only in the stub: solves the component.
        public void Solve(IGH_DataAccess access)
        {
            lock (Rhino.RhinoApp.Window)
            {
                Messages.Clear();
                SolveInstance(access);
            }
        }

        public void Register(GH_InputParamManager inputs) { RegisterInputParams(inputs); }

        protected abstract void RegisterInputParams(GH_InputParamManager pManager);
        protected abstract void RegisterOutputParams(GH_OutputParamManager pManager);
        protected abstract void SolveInstance(IGH_DataAccess DA);
    }
}
