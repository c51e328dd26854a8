"""BSDFs of glass for Mitsuba 3 that it does not have itself. For the variant that is set: register() after mi.set_variant."""
import drjit as dr
import mitsuba as mi


def register():
    class Body(mi.BSDF):
        """A smooth interface that absorbs what comes from inside: no media. With `schlick` it reflects as glTF's glass does, by
        Schlick's term where it meets air, and by Fresnel's between media."""

        def __init__(self, properties):
            mi.BSDF.__init__(self, properties)
            self.around = properties["ext_ior"]
            self.eta = properties["int_ior"] / self.around
            self.schlick = properties["schlick"] and self.around == 1.0
            self.absorption = mi.Color3f(properties["absorption"])
            self.tint = mi.Color3f(properties["tint"])
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [mi.BSDFFlags.DeltaReflection | sides,
                                 mi.BSDFFlags.DeltaTransmission | sides | mi.BSDFFlags.NonSymmetric]
            self.m_flags = self.m_components[0] | self.m_components[1]

        def sample(self, context, si, sample1, sample2, active=True):
            cosine = mi.Frame3f.cos_theta(si.wi)
            reflected, cosine_behind, eta_it, eta_ti = mi.fresnel(cosine, self.eta)
            if self.schlick:
                in_air = dr.select(cosine > 0, cosine, dr.abs(cosine_behind))
                reflected = dr.select(cosine_behind == 0, 1.0, schlick(in_air, self.eta))
            mirrored = sample1 <= reflected
            sample = dr.zeros(mi.BSDFSample3f)
            sample.pdf = dr.select(mirrored, reflected, 1 - reflected)
            sample.sampled_component = dr.select(mirrored, mi.UInt32(0), mi.UInt32(1))
            sample.sampled_type = dr.select(mirrored, mi.UInt32(+mi.BSDFFlags.DeltaReflection),
                                            mi.UInt32(+mi.BSDFFlags.DeltaTransmission))
            sample.wo = dr.select(mirrored, mi.reflect(si.wi), mi.refract(si.wi, cosine_behind, eta_ti))
            sample.eta = dr.select(mirrored, 1.0, eta_it)
            weight = dr.select(mirrored, mi.Color3f(1.0), self.tint * dr.square(eta_ti))
            weight *= dr.select(cosine < 0, dr.exp(-self.absorption * si.t), mi.Color3f(1.0))
            return sample, weight & active

        def eval(self, context, si, wo, active=True):
            return mi.Color3f(0.0)

        def pdf(self, context, si, wo, active=True):
            return mi.Float(0.0)

        def eval_pdf(self, context, si, wo, active=True):
            return mi.Color3f(0.0), mi.Float(0.0)

    class Thin(mi.BSDF):
        """A wall of glass without thickness: it mirrors by Schlick's term and lets the rest through, tinted and straight on, so
        that light passes it towards a lamp too."""

        def __init__(self, properties):
            mi.BSDF.__init__(self, properties)
            self.ior = properties["int_ior"]
            self.tint = mi.Color3f(properties["tint"])
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [mi.BSDFFlags.DeltaReflection | sides, mi.BSDFFlags.Null | sides]
            self.m_flags = self.m_components[0] | self.m_components[1]

        def sample(self, context, si, sample1, sample2, active=True):
            reflected = schlick(dr.abs(mi.Frame3f.cos_theta(si.wi)), self.ior)
            mirrored = sample1 <= reflected
            sample = dr.zeros(mi.BSDFSample3f)
            sample.pdf = dr.select(mirrored, reflected, 1 - reflected)
            sample.sampled_component = dr.select(mirrored, mi.UInt32(0), mi.UInt32(1))
            sample.sampled_type = dr.select(mirrored, mi.UInt32(+mi.BSDFFlags.DeltaReflection), mi.UInt32(+mi.BSDFFlags.Null))
            sample.wo = dr.select(mirrored, mi.reflect(si.wi), -si.wi)
            sample.eta = mi.Float(1.0)
            return sample, dr.select(mirrored, mi.Color3f(1.0), self.tint) & active

        def eval(self, context, si, wo, active=True):
            return mi.Color3f(0.0)

        def pdf(self, context, si, wo, active=True):
            return mi.Float(0.0)

        def eval_pdf(self, context, si, wo, active=True):
            return mi.Color3f(0.0), mi.Float(0.0)

        def eval_null_transmission(self, si, active=True):
            return self.tint * (1 - schlick(dr.abs(mi.Frame3f.cos_theta(si.wi)), self.ior)) & active

    mi.register_bsdf("glass_body", Body)
    mi.register_bsdf("glass_thin", Thin)


def schlick(cosine, eta):
    f0 = ((eta - 1) / (eta + 1)) ** 2
    return f0 + (1 - f0) * (1 - cosine) ** 5
