"""Builds the overlays of deploy/kubernetes like kustomize, and checks them.

Only the parts of kustomize that the files use are supported; others are rejected. If kubectl is
installed, it must build the same. Each resource is validated against the strict schemas of
Kubernetes; then labels that select pods, and names of ports, services and volumes, are compared.
"""

import contextlib
import copy
import pathlib
import re
import shutil
import subprocess

import kubernetes_validate
import yaml

OVERLAYS = ("one", "many")
# Versions of Kubernetes: the oldest with all fields, and the newest.
VERSIONS = ("1.30", kubernetes_validate.latest_version())


def run(*command: str | pathlib.Path, **options) -> str:
    """The output of a program that must succeed."""
    result = subprocess.run(command, capture_output=True, text=True, **options)
    if result.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}:\n{result.stdout}{result.stderr}")
    return result.stdout


def check(holds: object, reason: str) -> None:
    if not holds:
        raise SystemExit(reason)


def read(path: pathlib.Path) -> list:
    """The documents of a file."""
    with path.open() as file:
        return [document for document in yaml.safe_load_all(file) if document]


def kubernetes(directory: pathlib.Path) -> None:
    for name in OVERLAYS:
        folder = directory / name
        resources = kustomize(folder, [])
        if shutil.which("kubectl"):
            theirs = yaml.safe_load_all(run("kubectl", "kustomize", folder))
            compare(name, {key(r): r for r in resources}, {key(r): r for r in theirs})
        for resource in resources:
            with explained(f"{name}: {key(resource)}"):
                for version in VERSIONS:
                    kubernetes_validate.validate(resource, version, strict=True)
        fits_together(name, resources)


def merge(base, patch):
    """A strategic merge: mappings by key, lists of named things by name, other lists as a whole."""
    if isinstance(base, dict) and isinstance(patch, dict):
        return {key: merge(base.get(key), patch.get(key)) for key in [*base, *(key for key in patch if key not in base)]}
    if is_named(base) and is_named(patch):
        names = {item["name"]: item for item in base}
        merged = merge(names, {item["name"]: item for item in patch})
        # kustomize puts what the patch adds first.
        return [merged[name] for name in merged if name not in names] + [merged[name] for name in names]
    return copy.deepcopy(base if patch is None else patch)


def is_named(value) -> bool:
    return isinstance(value, list) and all(isinstance(item, dict) and "name" in item for item in value)


def kustomize(folder: pathlib.Path, resources: list[dict]) -> list[dict]:
    """Resources after a kustomization: rejects other parts of kustomize."""
    [kustomization] = read(folder / "kustomization.yaml")
    known = {"apiVersion", "kind", "resources", "components", "patches", "labels", "images"}
    check(set(kustomization) <= known, f"{folder.name}: {set(kustomization) - known} is not understood here")
    for file in kustomization.get("resources", []):
        resources = resources + read(folder / file)
    for component in kustomization.get("components", []):
        resources = kustomize(folder / component, resources)
    for patch in kustomization.get("patches", []):
        check(list(patch["target"]) == ["kind"], "a patch has a target that is not understood here")
        [changes] = read(folder / patch["path"])
        kinds = patch["target"]["kind"]
        hits = [resource for resource in resources if re.fullmatch(kinds, resource["kind"])]
        check(hits, f"{patch['path']} changes nothing")
        for resource in hits:
            resource["spec"] = merge(resource["spec"], changes["spec"])
    for labels in kustomization.get("labels", []):
        check(labels["includeSelectors"], "labels without selectors are not understood here")
        for resource in resources:
            label(resource, labels["pairs"])
    for image in kustomization.get("images", []):
        for container in (c for resource in resources for c in containers(resource)):
            if container["image"] == image["name"]:
                container["image"] = f"{image['newName']}:{image['newTag']}"
    return resources


def label(resource: dict, pairs: dict[str, str]) -> None:
    """Labels a resource, its templates and its selectors."""
    def add(owner: dict, *path: str) -> None:
        for key in path:
            owner = owner.setdefault(key, {})
        owner.update(pairs)

    add(resource, "metadata", "labels")
    spec = resource["spec"]
    match resource["kind"]:
        case "Service":
            add(spec, "selector")
        case "Deployment" | "StatefulSet":
            add(spec, "selector", "matchLabels")
            add(spec, "template", "metadata", "labels")
            for claim in spec.get("volumeClaimTemplates", []):
                add(claim, "metadata", "labels")
        case "PodDisruptionBudget":
            add(spec, "selector", "matchLabels")


def containers(resource: dict) -> list[dict]:
    return resource["spec"].get("template", {}).get("spec", {}).get("containers", [])


def key(resource: dict) -> str:
    return f"{resource['kind']} {resource['metadata']['name']}"


def compare(name: str, ours: dict, theirs: dict) -> None:
    check(ours.keys() == theirs.keys(), f"{name}: kubectl has {sorted(theirs)}, not {sorted(ours)}")
    for resource, content in ours.items():
        check(content == theirs[resource], f"{name}: kubectl has another {resource}:\n{theirs[resource]}\nnot\n{content}")


def fits_together(name: str, resources: list[dict]) -> None:
    """Checks beyond schemas: resources refer to existing names, and pods have no privileges."""
    [pods] = [resource for resource in resources if containers(resource)]
    [service] = [resource for resource in resources if resource["kind"] == "Service"]
    template = pods["spec"]["template"]
    [container] = template["spec"]["containers"]
    ports = {port["name"] for port in container["ports"]}
    for resource in resources:
        where = f"{name}: {key(resource)}"
        for selector in selectors(resource):
            check(selector and selector.items() <= template["metadata"]["labels"].items(), f"{where} selects other pods")
        check(ports_of_pods(resource) <= ports, f"{where} names a port that pods do not have")
        for target in targets(resource):
            check(target in (scaled(pods), served(service)), f"{where} names something else: {target}")
    security = container["securityContext"]
    check(security["readOnlyRootFilesystem"] and not security["allowPrivilegeEscalation"], f"{name}: pods have rights")
    check(template["spec"]["securityContext"]["runAsNonRoot"], f"{name}: pods run as root")
    volumes = [claim["metadata"]["name"] for claim in pods["spec"].get("volumeClaimTemplates", [])]
    volumes += [volume["name"] for volume in template["spec"].get("volumes", [])]
    mounts = [mount["name"] for mount in container.get("volumeMounts", [])]
    check(sorted(volumes) == sorted(mounts), f"{name}: pods mount other volumes")


def selectors(resource: dict) -> list[dict]:
    """The labels by which a resource selects pods."""
    match resource:
        case {"kind": "Service", "spec": {"selector": selector}}:
            return [selector]
        case {"kind": "NetworkPolicy", "spec": {"podSelector": selector}} | {"spec": {"selector": selector}}:
            return [selector.get("matchLabels", {})]
    return []


def ports_of_pods(resource: dict) -> set[str]:
    """Ports of pods that a resource names."""
    match resource:
        case {"kind": "Service", "spec": {"ports": ports}}:
            return {port["targetPort"] for port in ports}
        case {"kind": "NetworkPolicy", "spec": {"ingress": rules}}:
            return {port["port"] for rule in rules for port in rule["ports"]}
    return set()


def targets(resource: dict) -> list[tuple[str, str]]:
    """Other names in a resource: see `scaled` and `served`."""
    match resource:
        case {"kind": "Ingress", "spec": {"rules": rules}}:
            services = [path["backend"]["service"] for rule in rules for path in rule["http"]["paths"]]
            return [(service["name"], service["port"]["name"]) for service in services]
        case {"kind": "HorizontalPodAutoscaler", "spec": {"scaleTargetRef": target}}:
            return [(target["kind"], target["name"])]
    return []


def scaled(pods: dict) -> tuple[str, str]:
    return pods["kind"], pods["metadata"]["name"]


def served(service: dict) -> tuple[str, str]:
    [port] = service["spec"]["ports"]
    return service["metadata"]["name"], port["name"]


@contextlib.contextmanager
def explained(where: str):
    try:
        yield
    except Exception as error:
        raise SystemExit(f"{where}: {error}") from error
